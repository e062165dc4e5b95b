"""The administration: the state of the service, its workers, the queue."""

from collections.abc import Callable

from flask import Blueprint, flash, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from seamark.sandbox.languages import LANGUAGES
from seamark.server.accounts.audit import Actor
from seamark.server.accounts.permissions import Action
from seamark.server.administration import disk, live_runs, worker_list
from seamark.server.administration import overview as service_overview
from seamark.server.runs.ending import cancellation
from seamark.server.web import access
from seamark.server.web.services import services
from seamark.server.web.url_converters import row_id

page = Blueprint("administration", __name__, url_prefix="/admin")


@page.before_request
def _only_admins() -> None:
    access.require(Action.ADMINISTER)


@page.get("/")
def overview() -> ResponseReturnValue:
    """Show the state of the service and what needs a person."""
    held = services()
    with held.database.reading() as session:
        found = service_overview.overview(session, held.settings)
    return render_template("admin/overview.html", found=found, links=_links())


@page.get("/workers")
def workers() -> ResponseReturnValue:
    """Show the workers with what each of them runs."""
    with services().database.reading() as session:
        listed = worker_list.listed(session)
    labels = {name: language.label for name, language in LANGUAGES.items()}
    return render_template("admin/workers.html", workers=listed, labels=labels)


@page.post("/workers/drain")
def drain() -> ResponseReturnValue:
    """Let a worker start no more runs."""
    done = "The worker starts no more runs. It finishes those that it has."
    return _change_worker(worker_list.drain, done, "This worker is not listed or already drained.")


@page.post("/workers/resume")
def resume() -> ResponseReturnValue:
    """Let a drained worker start runs again."""
    answer = _change_worker(
        worker_list.resume, "The worker starts runs again.", "It is not drained."
    )
    services().wake_worker()
    return answer


@page.get("/queue")
def queue() -> ResponseReturnValue:
    """Show the runs that start next, and those that are evaluated."""
    with services().database.reading() as session:
        found = live_runs.listed(session)
    return render_template("admin/queue.html", found=found)


@page.post("/queue/cancel")
def cancel() -> ResponseReturnValue:
    """Cancel a queued or running run."""
    run_id = request.form.get("run", type=row_id)
    run = access.run_for(run_id or 0, Action.CANCEL)
    held, by = services(), access.not_owner(run)
    done = cancellation.cancel(held.database, held.redis, run.id, not_owner=by)
    flash(
        f"Run #{run.id} is cancelled." if done else f"Run #{run.id} had already ended.",
        "good" if done else "warn",
    )
    return redirect(url_for("administration.queue"), code=303)


@page.get("/storage")
def storage() -> ResponseReturnValue:
    """Show what takes how much room, and what retention would delete."""
    held = services()
    with held.database.reading() as session:
        found = disk.state(session, held.settings)
    return render_template("admin/storage.html", found=found, settings=held.settings)


@page.post("/storage/retention")
def run_retention() -> ResponseReturnValue:
    """Have a worker delete at once what retention would delete in time."""
    with services().database.writing() as session:
        disk.request_retention(session, access.actor())
    flash("A worker begins within seconds. This page shows what it has deleted.", "good")
    return redirect(url_for("administration.storage"), code=303)


def _change_worker(
    change: Callable[[Session, Actor, str], bool], done: str, why_not: str
) -> ResponseReturnValue:
    with services().database.writing() as session:
        changed = change(session, access.actor(), request.form.get("worker", "")[:255])
    flash(done if changed else why_not, "good" if changed else "warn")
    return redirect(url_for("administration.workers"), code=303)


def _links() -> dict[str, str]:
    """Return the pages to which warnings lead, by area."""
    return {
        "workers": url_for("administration.workers"),
        "queue": url_for("administration.queue"),
        "disk": url_for("administration.storage"),
        "runs": url_for("runs.mine", of="all", state="failed"),
        "status": url_for("status.show"),
        "audit": url_for("audit_log.show", action="sign_in_blocked"),
    }
