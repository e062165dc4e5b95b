"""My runs: newest first, by state, in parts of a fixed size; all of them as CSV."""

from collections.abc import Iterator
from typing import Any

from flask import Blueprint, Response, g, render_template, request
from flask.typing import ResponseReturnValue

from seamark.server.accounts.permissions import Viewer
from seamark.server.pages import benchmarks
from seamark.server.runs import quota, views
from seamark.server.runs.states import RunState
from seamark.server.runs.views import LIMIT_MAX, RunFilter, RunPage, RunView
from seamark.server.web import csv_export
from seamark.server.web.services import Services, services
from seamark.server.web.template_filters import iso, solution
from seamark.server.web.url_converters import row_id

SIZE = 25
COLUMNS = (
    *("run", "user", "benchmark", "kind", "program", "title", "state", "cause", "score"),
    *("score_low", "score_high", "level_held", "trials", "public", "queued_at", "finished_at"),
)
page = Blueprint("runs", __name__, url_prefix="/runs")


@page.get("/")
def mine() -> ResponseReturnValue:
    """Show the viewer's own runs; an admin may look at everybody's."""
    wanted, held = _wanted(g.viewer), services()
    part = _part(held, g.viewer, wanted, request.args.get("after", type=row_id), SIZE)
    with held.database.reading() as session:
        used = None if g.viewer.owner is None else quota.used_by(session, g.viewer, held.settings)
    return render_template(
        "runs/mine.html",
        part=part,
        states=list(RunState),
        wanted=wanted,
        first="after" not in request.args,
        quota=used,
        labels=benchmarks.labels(),
    )


@page.get("/runs.csv")
def as_csv() -> ResponseReturnValue:
    """Download the whole list, as it is filtered."""
    answer = Response(_lines(services(), g.viewer, _wanted(g.viewer)))
    answer.headers["Content-Type"] = csv_export.MEDIA_TYPE
    answer.headers["Content-Disposition"] = "attachment; filename=seamark-runs.csv"
    return answer


def _wanted(viewer: Viewer) -> RunFilter:
    """Return which runs the address asks for; those of others only for an admin."""
    everybody = viewer.is_admin and request.args.get("of") == "all"
    state = request.args.get("state", "")
    return RunFilter(
        which="all" if everybody else "mine",
        user=request.args.get("user", "").strip() or None if everybody else None,
        states=(RunState(state),) if state in list(RunState) else (),
    )


def _part(
    held: Services, viewer: Viewer, wanted: RunFilter, after: int | None, limit: int
) -> RunPage:
    with held.database.reading() as session:
        return views.page(session, viewer, wanted, after=after, limit=limit)


def _lines(held: Services, viewer: Viewer, wanted: RunFilter) -> Iterator[str]:
    """Make the CSV part by part: no transaction stays open while a slow reader reads."""
    yield csv_export.lines(COLUMNS, ())
    after: int | None = None
    while True:
        part = _part(held, viewer, wanted, after, LIMIT_MAX)
        yield csv_export.lines(COLUMNS, map(_row, part.runs), header=False)
        after = part.next
        if after is None:
            return


def _row(run: RunView) -> dict[str, Any]:
    same = {name: getattr(run, name) for name in COLUMNS if hasattr(run, name)}
    times = {"queued_at": iso(run.queued_at)}
    if run.finished_at is not None:
        times["finished_at"] = iso(run.finished_at)
    return {**same, "run": run.id, "program": solution(run), "state": run.state.value, **times}
