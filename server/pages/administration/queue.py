"""The queue, for admins: what starts next and what is evaluated; cancelling a run."""

from flask import flash, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.server.accounts.permissions import Action
from seamark.server.administration import live_runs
from seamark.server.pages.administration.admin_page import admin_page
from seamark.server.runs.ending import cancellation
from seamark.server.web import access
from seamark.server.web.services import services
from seamark.server.web.url_converters import row_id

ADMIN_PAGE = admin_page("admin_queue", __name__, label="Queue", path="/queue")
page = ADMIN_PAGE.blueprint


@page.get("")
def show() -> ResponseReturnValue:
    """Show the runs that start next, and those that are evaluated."""
    with services().database.reading() as session:
        live = live_runs.listed(session)
    return render_template("admin/queue.html", live=live)


@page.post("/cancel")
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
    return redirect(url_for("admin_queue.show"), code=303)
