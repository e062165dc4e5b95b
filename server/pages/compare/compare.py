"""Runs side by side, and the page on which to choose them."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from flask import Blueprint, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.sandbox.languages.language import DETECTOR
from seamark.server.accounts.permissions import Action, can
from seamark.server.pages.compare.compared_programs import program_differences
from seamark.server.pages.previews import link_previews
from seamark.server.programs import own_files
from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.record.seeds import trial_seeds
from seamark.server.runs.record.solutions import entry_name
from seamark.server.runs.showing import run_lists
from seamark.server.runs.showing.compared_curves import compared_curves
from seamark.server.runs.showing.comparison import reference_entries
from seamark.server.runs.showing.maps import map_of
from seamark.server.runs.showing.run_lists import RunFilter
from seamark.server.runs.showing.side_by_side import (
    COLUMNS_MAX,
    DIGEST,
    RUNS_MAX,
    RUNS_MIN,
    SideBySide,
    side_by_side,
)
from seamark.server.runs.showing.views import RunView
from seamark.server.storage.storage import StorageUnavailable
from seamark.server.web import access, compared_runs, known_benchmarks
from seamark.server.web.services import services
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.recording import telemetry

OFFERED = 10  # runs of each list
page = Blueprint("compare", __name__, url_prefix="/compare")


@page.get("")
def show() -> ResponseReturnValue:
    """Compare two to five runs; with fewer, offer runs to choose."""
    sent = request.args.getlist("runs")
    ids = compared_runs.ids_of(sent)
    if len(sent) > 1:  # the boxes of a form: one address for one comparison
        return redirect(_address(ids), code=303)
    runs = compared_runs.runs_of(ids)
    benchmark = known_benchmarks.by_name(_benchmark_name(runs))
    offered = _offered(benchmark, ids)
    if len(runs) < RUNS_MIN:
        return render_template(
            "compare/choose.html",
            runs=runs,
            benchmark=benchmark,
            benchmarks=known_benchmarks.labels(),
            offered=offered,
            runs_max=RUNS_MAX,
        )
    views = views_of(runs)
    return render_template(
        "compare/show.html",
        **views,
        benchmark=benchmark,
        settings=[row for row in views["comparison"].settings if row.name != DIGEST],
        programs=program_differences(runs),
        offered=offered if len(runs) < RUNS_MAX else {},
        address=_address,
        preview=link_previews.of_comparison(runs, _address(ids)),
    )


def views_of(runs: Sequence[RunView], names: Mapping[int, str] | None = None) -> dict[str, Any]:
    """Return the variables of compare/views.html: runs side by side, at least two.

    `names` are shown in place of those of the solutions.
    """
    compared = side_by_side(runs, partial(trial_seeds, settings=services().settings))
    return {
        "runs": runs,
        "names": names or {},
        "comparison": compared,
        "trials": max(run.trials for run in runs),
        "page_data": _page_data(runs, compared),
    }


def _address(ids: Sequence[int]) -> str:
    """Return the one address of a comparison."""
    return f"{url_for('compare.show')}?runs={','.join(map(str, ids))}"


def _benchmark_name(runs: Sequence[RunView]) -> str:
    if runs:
        return runs[0].benchmark
    return request.args.get("benchmark") or known_benchmarks.first().name


def _offered(benchmark: Benchmark, ids: Sequence[int]) -> dict[str, list[dict[str, Any]]]:
    """Return list -> runs of a benchmark that could be added; reference entries come first."""
    with services().database.reading() as session:
        marks = reference_entries(session, benchmark)
        leaders = leaderboard.page(session, benchmark.name, limit=OFFERED)
        mine = []
        if can(g.viewer, Action.LIST):
            run_filter = RunFilter(benchmark=benchmark.name)
            mine = run_lists.page(session, g.viewer, run_filter, limit=OFFERED + len(ids)).runs
    lists = {
        "Reference entries": [_choice(each.run_id, each.title, each.score) for each in marks],
        "My newest runs": [
            _choice(run.id, entry_name(run), run.score, state=run.state.value) for run in mine
        ],
        "Leaderboard": [
            _choice(rank.run_id, f"{rank.user}: {entry_name(rank)}", rank.score)
            for rank in leaders
            if not rank.is_baseline
        ],
    }
    taken = set(ids)
    shown: dict[str, list[dict[str, Any]]] = {}
    for title, choices in lists.items():
        rest = [each for each in choices if each["id"] not in taken]
        taken |= {each["id"] for each in rest}
        shown |= {title: rest} if rest else {}
    return shown


def _choice(run_id: int, title: str, score: float | None, *, state: str = "") -> dict[str, Any]:
    return {"id": run_id, "title": title, "score": score, "state": state}


def _page_data(runs: Sequence[RunView], comparison: SideBySide) -> Mapping[str, Any]:
    columns = [_columns(run) for run in runs]
    maps = {map_of([column["name"] for column in each]) for each in columns}
    return {
        "api": f"/api/v1/compare?runs={','.join(str(run.id) for run in runs)}",
        "runs": [
            {
                "id": run.id,
                "api": f"/api/v1/runs/{run.id}",
                "columns": names,
                "stages": registry.benchmark(run.benchmark).stage_labels,
                "before": registry.benchmark(run.benchmark).before_stages,
            }
            for run, names in zip(runs, columns, strict=True)
        ],
        "trial_s": max(_trial_s(run) for run in runs),
        "trials": max(run.trials for run in runs),
        "levels": comparison.levels,
        "level_s": _level_s(runs, comparison),
        "charts": _charts(runs),
        "curves": compared_curves(runs),
        "detections": all(map(_has_detections, runs)),
        "map": maps.pop() if len(maps) == 1 else None,
        "columns_max": COLUMNS_MAX,
    }


def _columns(run: RunView) -> list[dict[str, str]]:
    """Return the telemetry's columns of a run; none if it has no data, or they are away."""
    if run.data_deleted_at is not None:
        return []
    try:
        width = len(access.files_of(run).columns)
    except StorageUnavailable:
        return []
    return [{"name": column.name} for column in telemetry.columns(width)]


def _has_detections(run: RunView) -> bool:
    """Return whether the images of a run show answers of a detector instead of one target."""
    return registry.benchmark(run.benchmark).role == DETECTOR


def _trial_s(run: RunView) -> float:
    benchmark = registry.benchmark(run.benchmark)
    return benchmark.trial_duration_s(benchmark.restore(run.config))


def _level_s(runs: Sequence[RunView], comparison: SideBySide) -> float:
    """Return how long a level takes [s] if all runs have the same ones in their order; else 0."""
    lengths = {_trial_s(run) for run in runs}
    in_order = all(
        registry.benchmark(run.benchmark).restore(run.config).levels_in_order() for run in runs
    )
    return (
        lengths.pop() / len(comparison.levels)
        if comparison.levels and in_order and len(lengths) == 1
        else 0.0
    )


def _charts(runs: Sequence[RunView]) -> list[dict[str, str]]:
    """Return the single columns of the charts that all runs have, in the order of the first.

    How well a station is held is read in metres, how well a target is tracked in pixels.
    """
    charts = []
    for run in runs:
        benchmark = registry.benchmark(run.benchmark)
        with own_files.lent_to(services().settings, run):
            shown = benchmark.charts_of(benchmark.restore(run.config))
        charts.append(
            {
                column: {
                    "column": column,
                    "title": chart.title if len(chart.columns) == 1 else f"{chart.title}: {column}",
                    "unit": chart.unit,
                }
                for chart in shown
                for column in chart.columns
            }
        )
    first, *others = charts
    common = [chart for column, chart in first.items() if all(column in each for each in others)]
    unit = "m" if registry.benchmark(runs[0].benchmark).role == "controller" else "px"
    return sorted(common, key=lambda chart: chart["unit"] != unit)
