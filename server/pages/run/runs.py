"""The list of runs: filtered, searched and sorted, in pages; all of them as CSV."""

from collections.abc import Iterator
from typing import Any

from flask import Blueprint, Response, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.sandbox.languages import LANGUAGES
from seamark.server.accounts.permissions import Action, Viewer, can
from seamark.server.pages.run import selected_runs
from seamark.server.runs.record.solutions import team
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.showing import run_lists
from seamark.server.runs.showing.run_lists import (
    LIMIT_MAX,
    PROGRAMS,
    SEARCH_MAX,
    SEEN_MAX,
    ListCursor,
    RunFilter,
    RunOrder,
    RunPage,
)
from seamark.server.runs.showing.views import RunView
from seamark.server.runs.submission import quota
from seamark.server.web import access, csv_export, known_benchmarks
from seamark.server.web.services import Services, services
from seamark.server.web.template_filters import iso
from seamark.server.web.url_converters import row_id

SIZE = 25
COLUMNS = (
    *("run", "user", "benchmark", "kind", "program", "title", "state", "cause", "score"),
    *("score_low", "score_high", "level_held", "trials", "public", "queued_at", "finished_at"),
)
_IN_URL = ("of", "user", "q", "state", "benchmark", "kind", "program", "sort")
page = Blueprint("runs", __name__, url_prefix="/runs")


@page.get("/")
def mine() -> ResponseReturnValue:
    """Show the viewer's own runs; an admin may list those of all users."""
    access.require(Action.LIST)
    run_filter, order, app_services = _filter(g.viewer), _order(), services()
    start = ListCursor(request.args.get("after", type=row_id), request.args.get("skip", 0, int))
    runs = _page(app_services, g.viewer, run_filter, order, start, SIZE)
    with app_services.database.reading() as session:
        used = quota.used_by(session, g.viewer, app_services.settings) if g.viewer.owner else None
    return render_template(
        "runs/mine.html",
        page=runs,
        choices=_choices(),
        run_filter=run_filter,
        order=order,
        kept=_kept(),
        first="after" not in request.args,
        seen_max=SEEN_MAX,
        search_max=SEARCH_MAX,
        quota=used,
        may_list_all=can(g.viewer, Action.ADMINISTER),
    )


@page.get("/runs.csv")
def as_csv() -> ResponseReturnValue:
    """Download the whole filtered list."""
    access.require(Action.LIST)
    answer = Response(_lines(services(), g.viewer, _filter(g.viewer), _order()))
    answer.headers["Content-Type"] = csv_export.MEDIA_TYPE
    answer.headers["Content-Disposition"] = "attachment; filename=seamark-runs.csv"
    return answer


@page.post("/selected")
def change_selected() -> ResponseReturnValue:
    """Cancel, delete, publish, make private or compare the selected runs."""
    access.require(Action.SUBMIT)
    ids = [number for number in request.form.getlist("runs", row_id) if number is not None]
    chosen = list(dict.fromkeys(ids))[:LIMIT_MAX]
    if request.values.get("do", "") == "compare" and chosen:
        return redirect(f"{url_for('compare.show')}?runs={','.join(map(str, chosen))}", code=303)
    selected_runs.change(request.values.get("do", ""), chosen)
    return redirect(url_for("runs.mine", **_kept(), after=request.args.get("after")), code=303)


def _choices() -> dict[str, dict[str, str]]:
    """Return name -> choices of the filters of a list, with their labels."""
    of_languages = {name: language.label for name, language in LANGUAGES.items()}
    programs = {run_lists.BUILT_IN: "Built-in", run_lists.UPLOADED: "Uploaded"} | of_languages
    return {
        "state": {"": "All"} | {state.value: state.value.capitalize() for state in RunState},
        "benchmark": {"": "All"} | known_benchmarks.labels(),
        "kind": {"": "All"} | {kind.value: kind.value.capitalize() for kind in RunKind},
        "program": {"": "All"} | programs,
        "sort": {order.value: order.label for order in RunOrder},
    }


def _kept() -> dict[str, Any]:
    """Return what of the query string stays when a page is turned or something is changed."""
    return {name: request.args[name] for name in _IN_URL if request.args.get(name)}


def _filter(viewer: Viewer) -> RunFilter:
    """Return the filter in the query string; only an admin may list the runs of others."""
    everybody = can(viewer, Action.ADMINISTER) and request.args.get("of") == "all"
    state, kind = request.args.get("state", ""), request.args.get("kind", "")
    program = request.args.get("program", "")
    return RunFilter(
        which="all" if everybody else "mine",
        user=request.args.get("user", "").strip() or None if everybody else None,
        states=(RunState(state),) if state in list(RunState) else (),
        benchmark=request.args.get("benchmark", "")[:80] or None,
        kind=kind if kind in list(RunKind) else None,
        program=program if program in PROGRAMS else None,
        text=request.args.get("q", "").strip()[:SEARCH_MAX],
    )


def _order() -> RunOrder:
    wanted = request.args.get("sort", "")
    return RunOrder(wanted) if wanted in list(RunOrder) else RunOrder.NEWEST


def _page(
    app_services: Services,
    viewer: Viewer,
    run_filter: RunFilter,
    order: RunOrder,
    start: ListCursor,
    limit: int,
) -> RunPage:
    with app_services.database.reading() as session:
        return run_lists.page(session, viewer, run_filter, order=order, start=start, limit=limit)


def _lines(
    app_services: Services, viewer: Viewer, run_filter: RunFilter, order: RunOrder
) -> Iterator[str]:
    """Yield the CSV page by page: no transaction stays open while a slow client reads."""
    yield csv_export.lines(COLUMNS, ())
    start: ListCursor | None = ListCursor()
    while start is not None:
        runs = _page(app_services, viewer, run_filter, order, start, LIMIT_MAX)
        yield csv_export.lines(COLUMNS, map(_row, runs.runs), header=False)
        start = runs.next


def _row(run: RunView) -> dict[str, Any]:
    same = {name: getattr(run, name) for name in COLUMNS if hasattr(run, name)}
    times = {"queued_at": iso(run.queued_at)}
    if run.finished_at is not None:
        times["finished_at"] = iso(run.finished_at)
    return {**same, "run": run.id, "program": team(run), "state": run.state.value, **times}
