"""The metrics of a run that a leaderboard shows beside the score."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim import registry
from seamark.sim.metrics.metric import LevelMetric, Metric


def values(benchmark: str, metrics: Mapping[str, Any] | None) -> dict[str, float]:
    """Return name -> value of each metric that the run has.

    They are over the whole run, as its metrics.json has them: a metric of levels is combined by its
    own aggregation.
    """
    if benchmark not in registry.BENCHMARKS:
        return {}
    overall = (metrics or {}).get("overall") or {}
    levels = (metrics or {}).get("levels") or []
    return {
        metric.name: value
        for metric in registry.benchmark(benchmark).board_metrics
        if (value := _value(metric, overall, levels)) is not None and math.isfinite(value)
    }


def _value(
    metric: Metric, overall: Mapping[str, Any], levels: Sequence[Mapping[str, Any]]
) -> float | None:
    if metric.name in overall:
        value: float | None = overall[metric.name]
        return value
    if not isinstance(metric, LevelMetric) or not levels:
        return None
    if not all(metric.name in level for level in levels):
        return None
    return metric.over.of(metric.name, levels)
