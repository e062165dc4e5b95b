"""What a metric is. Each is declared once: name, unit, formula, aggregation and function.

A run's metrics.json, the tables of its page, the names that a custom score may use and
docs/measures.md all come from that declaration.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Literal, TypeVar

from seamark.sim.numerics.statistics import mean, root_mean_square

Levels = Sequence[Mapping[str, Any]]  # the metrics of each level by name
Absent = frozenset[str]  # columns of the telemetry that a log does not have
Source = TypeVar("Source")  # what a metric is computed from, such as a window of a level


@dataclass(frozen=True, slots=True)
class Metric:
    """A number with a name, a unit and a direction."""

    name: str
    label: str
    unit: str
    better: Literal["lower", "higher"]
    meaning: str = ""  # one more phrase where the label does not explain it


@dataclass(frozen=True, slots=True)
class Aggregation:
    """How the values of the levels, which are equally long, become one over the run.

    `of` takes the name of the metric and the metrics of each level.
    """

    description: str
    of: Callable[[str, Levels], float | None]


def _aggregation(
    description: str, combine: Callable[[Sequence[float]], float | None]
) -> Aggregation:
    """Return an aggregation of the values alone; None if a level has no value."""

    def of(name: str, levels: Levels) -> float | None:
        values = [level[name] for level in levels]
        return None if None in values else combine(values)

    return Aggregation(description, of)


def _maximum(values: Sequence[float]) -> float:
    return math.nan if any(map(math.isnan, values)) else max(values)


MEAN = _aggregation("mean of the levels", mean)
RMS = _aggregation("root mean square of the levels", root_mean_square)
SUM = _aggregation("sum of the levels", math.fsum)
MAX = _aggregation("maximum of the levels", _maximum)


def weighted_by(weight: str) -> Aggregation:
    """Return the mean of the levels weighted by another metric; nan if all weights are 0."""

    def of(name: str, levels: Levels) -> float | None:
        weighted = [(level[name], level[weight]) for level in levels if level[weight]]
        if any(value is None for value, _ in weighted):
            return None
        total = math.fsum(count for _, count in weighted)
        return math.fsum(value * count for value, count in weighted) / total if total else math.nan

    return Aggregation(f"mean of the levels, weighted by `{weight}`", of)


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelMetric(Metric, Generic[Source]):
    """A metric of one level, computed from its telemetry.

    `compute` returns nan where the value is undefined, and None where there is none. `reads` are
    the columns of the telemetry that it depends on, of metrics that logs of missions have too.
    """

    formula: str
    reads: tuple[str, ...] = ()
    compute: Callable[[Source], float | None]
    over: Aggregation = MEAN


@dataclass(frozen=True, slots=True)
class MetricGroup:
    """Metrics that are documented together."""

    title: str
    metrics: tuple[LevelMetric[Any], ...]


def compute_all(
    metrics: Iterable[LevelMetric[Source]],
    source: Source,
    *,
    prefix: str = "",
    absent: Absent = frozenset(),
) -> dict[str, float | None]:
    """Return name -> value of each metric, in the order of their declarations.

    None of those that read a column that was not measured.
    """
    return {
        f"{prefix}{metric.name}": None if absent & set(metric.reads) else metric.compute(source)
        for metric in metrics
    }


def over_run(metrics: Iterable[LevelMetric[Any]], levels: Levels) -> dict[str, float | None]:
    """Return each metric over all levels of a trial, from the metrics of each level."""
    return {metric.name: metric.over.of(metric.name, levels) for metric in metrics}


def over_whole_run(
    metric: Metric, overall: Mapping[str, float | None], levels: Levels
) -> float | None:
    """Return a metric over a run, from those of the run and of its levels; None if it has none."""
    if metric.name in overall:
        return overall[metric.name]
    if not isinstance(metric, LevelMetric) or not levels:
        return None
    if not all(metric.name in level for level in levels):
        return None
    return metric.over.of(metric.name, levels)


def mean_over_trials(trials: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the mean of each metric over trials, nested ones too; None where one has none."""
    result: dict[str, Any] = {}
    for name, first in trials[0].items():
        values = [trial[name] for trial in trials]
        if isinstance(first, Mapping):
            result[name] = mean_over_trials(values)
        elif name == "held":
            result[name] = None if None in values else all(values)
        elif name == "level" or isinstance(first, str):
            result[name] = first
        else:
            missing = any(value is None for value in values)
            result[name] = None if missing else mean([float(value) for value in values])
    return result
