"""The chart of metrics over levels, from the metrics of a run or its telemetry so far."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from seamark.server.runs.files import RunFiles
from seamark.server.runs.views import RunView
from seamark.sim.benchmarks.benchmark import Benchmark, Curve
from seamark.sim.numerics.statistics import mean
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.settings.configuration import Configuration


def curve(
    benchmark: Benchmark, config: Configuration, run: RunView, files: RunFiles
) -> dict[str, Any] | None:
    """Return the chart as JSON; None for a benchmark without one.

    `x` holds the values of the completed levels in the unit of the score, `lines` the metrics of
    these levels as means over the trials. `mark` is the score, or the first value so far at which
    the first line is below the limit.
    """
    chart = benchmark.curve
    if chart is None:
        return None
    levels: Sequence[Mapping[str, Any]] = (run.metrics or {}).get("levels") or []
    if not levels:
        levels = _so_far(chart, files.rows(), ended=run.state.final)
    headline = benchmark.headline_of(config)
    values = chart.values(config)
    x = values[: len(levels)]
    first = [level[chart.metrics[0].name] for level in levels]
    failed = next((at for at, value in zip(x, first, strict=True) if value < chart.limit), None)
    mark = run.score if run.score is not None else failed
    labels = [metric.label for metric in chart.metrics]
    return {
        "title": f"{' and '.join(labels)} over the {headline.unit}",
        "sentence": _sentence(labels[0], chart.limit, headline.label, mark, final=run.state.final),
        "unit": chart.metrics[0].unit,
        "x_label": headline.unit,
        "range": [values[0], values[-1]],
        "x": list(x),
        "lines": [
            {"label": metric.label, "values": [level[metric.name] for level in levels]}
            for metric in chart.metrics
        ],
        "limit": chart.limit,
        "mark": mark,
        "mark_label": headline.label,
    }


def _sentence(first: str, limit: float, score: str, mark: float | None, *, final: bool) -> str:
    if mark is None:
        state = "did" if final else "has"
        fall = "not fall" if final else "not fallen"
        return f"{first} {state} {fall} below {limit:g} %, which would be {score}."
    sofar = "" if final else " so far"
    return f"{score}, where {first} falls below {limit:g} %, is {mark:.2f}{sofar}."


def _so_far(chart: Curve, rows: Rows, *, ended: bool) -> list[dict[str, float]]:
    """Return the metrics of the completed levels, as means over the trials."""
    position = rows[:, [INDEX["trial"], INDEX["level"]]]
    starts = [0, *(np.flatnonzero((np.diff(position, axis=0) != 0).any(axis=1)) + 1).tolist()]
    ends = [*starts[1:], len(rows)] if ended and len(rows) else starts[1:]
    measured = sorted(
        (
            (int(rows[a, INDEX["level"]]), chart.measure(rows[a:b]))
            for a, b in zip(starts, ends, strict=False)
        ),
        key=lambda item: item[0],
    )
    names = [metric.name for metric in chart.metrics]
    return [
        {name: mean([found[name] for found in same]) for name in names}
        for same in (
            [found for _, found in members]
            for _, members in groupby(measured, key=lambda item: item[0])
        )
    ]
