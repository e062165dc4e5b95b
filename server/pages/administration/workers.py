"""The workers, for admins: what each of them runs, draining and resuming them."""

from collections.abc import Callable

from flask import flash, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from seamark.sandbox.languages import LANGUAGES
from seamark.server.accounts.audit import Actor
from seamark.server.administration import worker_list
from seamark.server.pages.administration.admin_page import admin_page
from seamark.server.web import access
from seamark.server.web.services import services

ADMIN_PAGE = admin_page("admin_workers", __name__, label="Workers", path="/workers")
page = ADMIN_PAGE.blueprint


@page.get("")
def show() -> ResponseReturnValue:
    """Show the workers with what each of them runs."""
    with services().database.reading() as session:
        listed = worker_list.listed(session)
    labels = {name: language.label for name, language in LANGUAGES.items()}
    return render_template("admin/workers.html", workers=listed, labels=labels)


@page.post("/drain")
def drain() -> ResponseReturnValue:
    """Let a worker start no more runs."""
    done = "The worker starts no more runs. It finishes those that it has."
    return _change_worker(worker_list.drain, done, "This worker is not listed or already drained.")


@page.post("/resume")
def resume() -> ResponseReturnValue:
    """Let a drained worker start runs again."""
    answer = _change_worker(
        worker_list.resume, "The worker starts runs again.", "It is not drained."
    )
    services().wake_worker()
    return answer


def _change_worker(
    change: Callable[[Session, Actor, str], bool], done: str, why_not: str
) -> ResponseReturnValue:
    with services().database.writing() as session:
        changed = change(session, access.actor(), request.form.get("worker", "")[:255])
    flash(done if changed else why_not, "good" if changed else "warn")
    return redirect(url_for("admin_workers.show"), code=303)
