"""The charts of metrics over levels of runs side by side, from their metrics."""

from collections.abc import Mapping, Sequence
from typing import Any

from seamark.server.runs.showing.score_differences import ComparedRun
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark, Curve


def compared_curves(runs: Sequence[ComparedRun]) -> list[dict[str, Any]]:
    """Return the charts of these runs as JSON: of each, the first metric of every run.

    There are none for runs of several benchmarks, nor of charts that no run has values for.
    """
    if len({run.benchmark for run in runs}) > 1:
        return []
    benchmark = registry.benchmark(runs[0].benchmark)
    charts = [
        _chart(benchmark, curve, runs) for curve in benchmark.curves or _usual(benchmark, runs)
    ]
    return [chart for chart in charts if any(line["x"] for line in chart["lines"])]


def _usual(benchmark: Benchmark, runs: Sequence[ComparedRun]) -> tuple[Curve, ...]:
    """Return the chart of a benchmark without curves: its first metric over what its levels are."""
    configs = [benchmark.restore(run.config) for run in runs]
    level, metric = configs[0].level_metric(), benchmark.key_metrics[0]
    if any(len(set(config.level_values())) < len(config.level_values()) for config in configs):
        return ()
    x_label = f"{level.label} [{level.unit}]" if level.unit else level.label
    return (
        Curve(
            metrics=(metric,),
            limit=0.0,
            values=lambda config: config.level_values(),
            measure=lambda _: {},
            x_label=x_label,
        ),
    )


def _chart(benchmark: Benchmark, curve: Curve, runs: Sequence[ComparedRun]) -> dict[str, Any]:
    metric = curve.metrics[0]
    x_label = curve.x_label or benchmark.headline.unit
    return {
        "title": f"{metric.label} over the {x_label[:1].lower()}{x_label[1:].partition(' [')[0]}",
        "unit": metric.unit,
        "x_label": x_label,
        "limit": curve.limit,
        "lines": [_line(benchmark, curve, run) for run in runs],
    }


def _line(benchmark: Benchmark, curve: Curve, run: ComparedRun) -> dict[str, list[float]]:
    """Return the points of a run that has metrics, in increasing order."""
    levels: Sequence[Mapping[str, Any]] = (run.metrics or {}).get("levels") or []
    config = benchmark.restore(run.config)
    values = curve.values(config)
    chosen = range(len(values)) if curve.levels is None else curve.levels(config)
    name = curve.metrics[0].name
    points = sorted(
        (values[at], levels[at][name])
        for at in chosen
        if at < len(levels) and levels[at].get(name) is not None
    )
    return {"x": [x for x, _ in points], "values": [value for _, value in points]}
