"""The chart of metrics over levels, from the metrics of a run or its telemetry so far."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from operator import itemgetter
from typing import Any

from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.data.level_spans import level_spans
from seamark.server.runs.showing.views import RunView
from seamark.sim.benchmarks.benchmark import Benchmark, Curve
from seamark.sim.metrics.metric import Metric
from seamark.sim.numerics.statistics import mean
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.settings.configuration import Configuration


def curves(
    benchmark: Benchmark, config: Configuration, run: RunView, files: RunFiles
) -> list[dict[str, Any]]:
    """Return the charts as JSON; none for a benchmark without any.

    `x` holds the values of the completed levels in increasing order, `lines` the metrics of these
    levels as means over the trials. `mark` is the score or the area that belongs to the chart; for
    a score that is neither, the first value so far at which the first line is below the limit.
    """
    if not benchmark.curves:
        return []
    done: dict[int, Mapping[str, Any]] = dict(enumerate((run.metrics or {}).get("levels") or []))
    spans = [] if done else level_spans(files, ended=run.state.final)
    return [
        _curve(chart, config, run, done or _so_far(chart, files, spans), headline)
        for chart in benchmark.curves
        if (headline := chart.area or benchmark.headline_of(config))
    ]


def _curve(
    chart: Curve,
    config: Configuration,
    run: RunView,
    done: Mapping[int, Mapping[str, Any]],
    marked: Metric,
) -> dict[str, Any]:
    values = chart.values(config)
    chosen = range(len(values)) if chart.levels is None else chart.levels(config)
    points = sorted((values[level], level) for level in chosen if level in done)
    x, levels = [value for value, _ in points], [done[level] for _, level in points]
    mark = _mark(chart, run, x, levels)
    labels = [metric.label for metric in chart.metrics]
    ends = [values[level] for level in chosen]
    return {
        "title": f"{' and '.join(labels)} over the {_lower_first(chart.x_label) or marked.unit}",
        "explanation": _explanation(chart),
        "sentence": _sentence(chart, labels[0], marked, mark, final=run.state.final),
        "unit": chart.metrics[0].unit,
        "x_label": chart.x_label or marked.unit,
        "range": [min(ends), max(ends)],
        "x": x,
        "lines": [
            {"label": metric.label, "values": [level[metric.name] for level in levels]}
            for metric in chart.metrics
        ],
        "limit": chart.limit,
        "mark": mark,
        "mark_label": marked.label,
    }


def _explanation(chart: Curve) -> str:
    """Return what the lines of a chart are."""
    lines = "; ".join(f"{metric.label}: {metric.meaning}" for metric in chart.metrics)
    return f"{lines}. A level fails below the dashed line."


def _lower_first(text: str) -> str:
    return text[:1].lower() + text[1:]


def _mark(
    chart: Curve, run: RunView, x: Sequence[float], levels: Sequence[Mapping[str, Any]]
) -> float | None:
    """Return where the chart is marked, if that is known yet."""
    if chart.area is not None:
        overall: Mapping[str, float | None] = (run.metrics or {}).get("overall") or {}
        return overall.get(chart.area.name, run.score)
    if run.score is not None:
        return run.score
    first = (level[chart.metrics[0].name] for level in levels)
    return next((at for at, value in zip(x, first, strict=True) if value < chart.limit), None)


def _sentence(chart: Curve, first: str, marked: Metric, mark: float | None, *, final: bool) -> str:
    if chart.area is not None:
        value = "" if mark is None else f", is {mark:.2f} {marked.unit}".rstrip()
        known = value or " is known when the run has finished"
        return f"{marked.label}, the area under {first}{known}."
    if mark is None:
        state = "did" if final else "has"
        fall = "not fall" if final else "not fallen"
        return f"{first} {state} {fall} below {chart.limit:g} %, which would be {marked.label}."
    sofar = "" if final else " so far"
    return f"{marked.label}, where {first} falls below {chart.limit:g} %, is {mark:.2f}{sofar}."


def _so_far(
    chart: Curve, files: RunFiles, spans: Sequence[tuple[int, int]]
) -> dict[int, dict[str, float]]:
    """Return the metrics of levels by their index, as means over the trials.

    One level at a time is in memory: whoever looks at a run may come with many others.
    """
    measured = sorted((_measured(chart, files.rows(*span)) for span in spans), key=itemgetter(0))
    names = [metric.name for metric in chart.metrics]
    by_level = groupby(measured, key=itemgetter(0))
    return {
        level: {name: mean([values[name] for _, values in members]) for name in names}
        for level, group in by_level
        if (members := list(group))
    }


def _measured(chart: Curve, rows: Rows) -> tuple[int, Mapping[str, float]]:
    return int(rows[0, INDEX["level"]]), chart.measure(rows)
