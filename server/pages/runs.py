"""The list of runs: newest first, filtered, in pages; all of them as CSV."""

from collections.abc import Iterator
from typing import Any

from flask import Blueprint, Response, g, render_template, request
from flask.typing import ResponseReturnValue

from seamark.server.accounts.permissions import Action, Viewer, can
from seamark.server.pages import benchmarks
from seamark.server.runs import quota, views
from seamark.server.runs.solutions import solution
from seamark.server.runs.states import RunState
from seamark.server.runs.views import LIMIT_MAX, RunFilter, RunPage, RunView
from seamark.server.web import access, csv_export
from seamark.server.web.services import Services, services
from seamark.server.web.template_filters import iso
from seamark.server.web.url_converters import row_id

SIZE = 25
COLUMNS = (
    *("run", "user", "benchmark", "kind", "program", "title", "state", "cause", "score"),
    *("score_low", "score_high", "level_held", "trials", "public", "queued_at", "finished_at"),
)
page = Blueprint("runs", __name__, url_prefix="/runs")


@page.get("/")
def mine() -> ResponseReturnValue:
    """Show the viewer's own runs; an admin may list those of all users."""
    access.require(Action.LIST)
    run_filter, app_services = _filter(g.viewer), services()
    runs = _page(app_services, g.viewer, run_filter, request.args.get("after", type=row_id), SIZE)
    with app_services.database.reading() as session:
        used = quota.used_by(session, g.viewer, app_services.settings) if g.viewer.owner else None
    return render_template(
        "runs/mine.html",
        page=runs,
        states=list(RunState),
        run_filter=run_filter,
        first="after" not in request.args,
        quota=used,
        labels=benchmarks.labels(),
        may_list_all=can(g.viewer, Action.ADMINISTER),
    )


@page.get("/runs.csv")
def as_csv() -> ResponseReturnValue:
    """Download the whole filtered list."""
    access.require(Action.LIST)
    answer = Response(_lines(services(), g.viewer, _filter(g.viewer)))
    answer.headers["Content-Type"] = csv_export.MEDIA_TYPE
    answer.headers["Content-Disposition"] = "attachment; filename=seamark-runs.csv"
    return answer


def _filter(viewer: Viewer) -> RunFilter:
    """Return the filter in the query string; only an admin may list the runs of others."""
    everybody = can(viewer, Action.ADMINISTER) and request.args.get("of") == "all"
    state = request.args.get("state", "")
    return RunFilter(
        which="all" if everybody else "mine",
        user=request.args.get("user", "").strip() or None if everybody else None,
        states=(RunState(state),) if state in list(RunState) else (),
    )


def _page(
    app_services: Services, viewer: Viewer, run_filter: RunFilter, after: int | None, limit: int
) -> RunPage:
    with app_services.database.reading() as session:
        return views.page(session, viewer, run_filter, after=after, limit=limit)


def _lines(app_services: Services, viewer: Viewer, run_filter: RunFilter) -> Iterator[str]:
    """Yield the CSV page by page: no transaction stays open while a slow client reads."""
    yield csv_export.lines(COLUMNS, ())
    after: int | None = None
    while True:
        runs = _page(app_services, viewer, run_filter, after, LIMIT_MAX)
        yield csv_export.lines(COLUMNS, map(_row, runs.runs), header=False)
        after = runs.next
        if after is None:
            return


def _row(run: RunView) -> dict[str, Any]:
    same = {name: getattr(run, name) for name in COLUMNS if hasattr(run, name)}
    times = {"queued_at": iso(run.queued_at)}
    if run.finished_at is not None:
        times["finished_at"] = iso(run.finished_at)
    return {**same, "run": run.id, "program": solution(run), "state": run.state.value, **times}
