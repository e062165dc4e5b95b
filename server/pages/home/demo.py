"""The demo: a recorded run that plays at once, and the same run computed live behind it."""

from typing import Any

from flask import Blueprint, flash, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.server.accounts.permissions import Action
from seamark.server.pages.run.player_data import player_data
from seamark.server.pages.submission import prefill
from seamark.server.runs.showing import recorded_demo
from seamark.server.runs.submission import submission, validation
from seamark.server.runs.submission.quota import QuotaExceeded
from seamark.server.runs.submission.validation import Submission
from seamark.server.storage.storage import StorageUnavailable
from seamark.server.web import access, authentication, known_benchmarks
from seamark.server.web.rate_limits import SUBMISSIONS, client, limiter
from seamark.server.web.services import services

TITLE = "Demo: the built-in PI controller"
page = Blueprint("demo", __name__)


@page.get("/demo")
def show() -> ResponseReturnValue:
    """Show the recorded run, and how far the viewer's own live one is."""
    run = recorded_demo.run()
    live = prefill.visible_run(request.args.get("run", ""))
    return render_template(
        "home/demo.html",
        run=run,
        benchmark=known_benchmarks.by_name(run.benchmark),
        live=live,
        same=live is not None and live.digest == recorded_demo.digest(),
        has_rows=True,
        axes="",
        protocol=None,
        tracks=True,
        poster=True,
        page_data=recording(),
    )


@page.post("/demo")
@limiter.limit(SUBMISSIONS, key_func=client)
def start() -> ResponseReturnValue:
    """Start the run of the demo live, and show the recorded one meanwhile."""
    access.require_scope(Action.SUBMIT)
    try:
        run_id = _start()
    except (QuotaExceeded, StorageUnavailable) as refusal:
        flash(f"The demo is not started live. {refusal}", "warn")
        return redirect(url_for("demo.show"), code=303)
    services().wake_worker()  # only after the commit: the worker must find the row
    return redirect(url_for("demo.show", run=run_id), code=303)


def recording() -> dict[str, Any]:
    """Return what the player needs to play the recorded run."""
    data = player_data(recorded_demo.run(), recorded_demo.files())
    return data | {"id": "demo", "api": "/api/v1/demo"}


def _start() -> int:
    run = Submission(
        viewer=authentication.become_guest(),
        benchmark=recorded_demo.BENCHMARK,
        config=recorded_demo.SETTINGS,
        kind=recorded_demo.run().kind,
        controller=recorded_demo.CONTROLLER,
        seed=recorded_demo.SEED,
        title=TITLE,
    )
    valid = validation.validate(run, services().settings)
    with services().database.writing() as session:
        return submission.submit(session, valid, services().settings)
