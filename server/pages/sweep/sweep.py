"""The page of a sweep: its table, a heat map or a curve of the scores, and the best point."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flask import Blueprint, flash, redirect, render_template, url_for
from flask.typing import ResponseReturnValue

from seamark.programs.setting_values import label_of
from seamark.server.accounts.permissions import Action
from seamark.server.pages.sweep import sweep_chart, sweep_edges
from seamark.server.runs.ending import cancellation
from seamark.server.runs.showing.views import RunView
from seamark.server.runs.submission.sweep_axes import Axis, Value, shown
from seamark.server.runs.submission.sweeps import Cell, SweepView
from seamark.server.web import access, known_benchmarks
from seamark.server.web.services import services
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.metrics.metric import Metric

HEATS = 8  # colours of the heat map, from the lowest to the highest score
page = Blueprint("sweep", __name__, url_prefix="/sweeps")


@dataclass(frozen=True, slots=True)
class AxisView:
    """An axis as the page shows it."""

    title: str
    unit: str
    labels: tuple[str, ...]


@page.get("/<row:sweep_id>")
def show(sweep_id: int) -> ResponseReturnValue:
    """Show a sweep."""
    sweep = access.sweep_for(sweep_id)
    benchmark = known_benchmarks.by_name(sweep.benchmark)
    axes = _axes(benchmark, sweep)
    return render_template(
        "sweep/show.html",
        sweep=sweep,
        benchmark=benchmark,
        axes=axes,
        points=_points(sweep, axes),
        heats=heats(sweep.cells),
        chart=sweep_chart.curve(sweep) if len(axes) == 1 else None,
        edges=sweep_edges.warnings(sweep, benchmark.schema()["properties"]),
        headline=_headline(benchmark, sweep.runs),
    )


@page.post("/<row:sweep_id>/cancel")
def cancel(sweep_id: int) -> ResponseReturnValue:
    """Cancel the runs of a sweep that have not ended."""
    access.sweep_for(sweep_id, Action.CANCEL)
    count = cancellation.cancel_sweep(services().database, services().redis, sweep_id)
    runs = "run is" if count == 1 else "runs are"
    flash(f"{count} {runs} cancelled. What was recorded so far is kept.", "good")
    return redirect(url_for("sweep.show", sweep_id=sweep_id), code=303)


def heats(cells: Sequence[Cell]) -> list[int | None]:
    """Return the colour of each cell, 0 for the lowest score; None without a score."""
    scores = [None if cell.run is None else cell.run.score for cell in cells]
    known = [score for score in scores if score is not None]
    if not known:
        return [None] * len(scores)
    low, span = min(known), max(known) - min(known)
    return [
        None
        if score is None
        else min(int(HEATS * (score - low) / span), HEATS - 1)
        if span > 0.0
        else HEATS // 2
        for score in scores
    ]


def _axes(benchmark: Benchmark, sweep: SweepView) -> tuple[AxisView, ...]:
    entries: dict[str, Any] = benchmark.schema()["properties"]
    return tuple(_axis(axis, entries.get(axis.name)) for axis in sweep.axes)


def _axis(axis: Axis, entry: dict[str, Any] | None) -> AxisView:
    def label(value: Value) -> str:
        return shown(value) if entry is None or type(value) is float else label_of(entry, value)

    title = axis.name if entry is None else entry["title"]
    unit = "" if entry is None else entry.get("x-unit", "")
    return AxisView(title, unit, tuple(label(value) for value in axis.values))


def _points(sweep: SweepView, axes: Sequence[AxisView]) -> list[str]:
    """Return each cell in words, such as "Kp 0.4 1/s, Ki 0.02 1/s²"."""
    labels = [
        dict(zip(axis.values, shown.labels, strict=True))
        for axis, shown in zip(sweep.axes, axes, strict=True)
    ]
    return [
        ", ".join(
            f"{shown.title} {names[value]} {shown.unit}".rstrip()
            for shown, names, value in zip(axes, labels, cell.values, strict=True)
        )
        for cell in sweep.cells
    ]


def _headline(benchmark: Benchmark, runs: Sequence[RunView]) -> Metric:
    config = benchmark.restore(runs[0].config if runs else {})
    return benchmark.headline_of(config)
