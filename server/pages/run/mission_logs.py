"""Open a log: the form that makes a run of the kind `log` from a file."""

from flask import Blueprint, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.mission_logs.mapping import TEXT_MAX
from seamark.mission_logs.result import LogRefused
from seamark.mission_logs.scope import SUFFIXES, measurable
from seamark.server.accounts.permissions import Action
from seamark.server.programs.fair_semaphore import SlotsBusy
from seamark.server.runs.logs.log_reader import LogTooLarge
from seamark.server.runs.record import run_notes
from seamark.server.runs.submission.quota import QuotaExceeded
from seamark.server.storage.storage import StorageUnavailable
from seamark.server.web import access, body_limits, known_benchmarks
from seamark.server.web.mission_logs import open_log
from seamark.server.web.rate_limits import SUBMISSIONS, client, limiter
from seamark.server.web.services import services

page = Blueprint("mission_logs", __name__, url_prefix="/logs")


@page.get("/new")
def form() -> ResponseReturnValue:
    """Show the form."""
    access.require(Action.UPLOAD)
    return _show({})


@page.post("/new")
@limiter.limit(SUBMISSIONS, key_func=client)
def create() -> ResponseReturnValue:
    """Measure and store a log, or show the form again with the reason why not."""
    access.require(Action.UPLOAD)
    posted = body_limits.form_fields()
    file = request.files.get("log")
    try:
        run_id = open_log(
            file,
            posted.get("mapping", ""),
            benchmark=posted.get("benchmark", ""),
            title=posted.get("title", "") or (file.filename if file else "") or "",
        )
    except LogTooLarge as refusal:
        return _show(posted, str(refusal)), 413
    except LogRefused as refusal:
        return _show(posted, str(refusal)), 422
    except QuotaExceeded as refusal:
        return _show(posted, str(refusal)), 429
    except SlotsBusy as refusal:
        return _show(posted, str(refusal)), 503, {"Retry-After": str(refusal.retry_after_s)}
    except StorageUnavailable as refusal:
        return _show(posted, f"{refusal} Try again in a moment."), 503
    return redirect(url_for("run.show", run_id=run_id), code=303)


def _show(posted: dict[str, str], error: str = "") -> str:
    labels = known_benchmarks.labels()
    return render_template(
        "logs/form.html",
        posted=posted,
        error=error,
        chosen=posted.get("benchmark") or known_benchmarks.first().name,
        benchmarks={name: labels[name] for name in measurable()},
        suffixes=SUFFIXES,
        mapping_max=TEXT_MAX,
        title_max=run_notes.TITLE_MAX,
        upload_max=services().settings.upload_max_bytes,
    )
