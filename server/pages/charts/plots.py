"""Axes of the small plots that pages draw as SVG: scores with intervals, ranks, Pareto fronts.

Positions are percentages of the plot's width or height, so that a plot fits any screen while its
text keeps its size.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol, Self

from seamark.server.pages.charts import label_placement
from seamark.server.pages.charts.label_placement import Label, Point
from seamark.server.runs.leaderboard.leaderboard_filters import Measured
from seamark.sim.metrics.metric import Metric

TICKS = 5  # at most, on an axis
_POWERS_MIN = 3  # on a logarithmic axis; a shorter one is nearly linear
_MARGIN = 2.0  # [%] free at both ends
_STEPS = (1.0, 2.0, 5.0, 10.0)


@dataclass(frozen=True, slots=True)
class Axis:
    """A linear or logarithmic axis over the values it was made for."""

    low: float
    high: float
    logarithmic: bool = False

    @classmethod
    def over(cls, values: Iterable[float], *, logarithmic: bool = False) -> Self:
        """Return the axis from the least to the greatest of some values."""
        known = [value for value in values if math.isfinite(value)]
        positive = logarithmic and bool(known) and min(known) > 0.0
        low, high = (min(known), max(known)) if known else (0.0, 1.0)
        if low == high:
            spare = 0.5 * abs(low) or 0.5
            low, high = low - spare, high + spare
        return cls(low, high, positive)

    def at(self, value: float) -> float:
        """Return the position of a value [%]; a value beyond an end is put there."""
        low, high = self._scaled(self.low), self._scaled(self.high)
        share = (self._scaled(value) - low) / (high - low)
        inside = min(max(share, 0.0), 1.0)
        return round(_MARGIN + (100.0 - 2.0 * _MARGIN) * inside, 2)

    def up(self, value: float) -> float:
        """Return the position on a vertical axis, from the top [%]."""
        return round(100.0 - self.at(value), 2)

    def has(self, value: float) -> bool:
        """Return whether a value is on the axis."""
        return self.low <= value <= self.high

    def ticks(self) -> list[float]:
        """Return some round values on the axis."""
        powers = _powers(self.low, self.high) if self.logarithmic else []
        if len(powers) >= _POWERS_MIN:
            return powers
        step = _step((self.high - self.low) / TICKS)
        first = math.ceil(self.low / step)
        return [round(k * step, 12) + 0.0 for k in range(first, math.floor(self.high / step) + 1)]

    def _scaled(self, value: float) -> float:
        if not self.logarithmic:
            return value
        return math.log(value) if value > 0.0 else math.log(self.low)


class OnAxis(Protocol):
    """A score with its interval; rows of a leaderboard and reference entries have it."""

    @property
    def score(self) -> float: ...  # noqa: D102 - the attribute of Rank
    @property
    def low(self) -> float: ...  # noqa: D102
    @property
    def high(self) -> float: ...  # noqa: D102
    @property
    def is_baseline(self) -> bool: ...  # noqa: D102


class Plotted(Measured, Protocol):
    """An entry with metrics and a name; rows of a leaderboard and reference entries have both."""

    @property
    def is_baseline(self) -> bool: ...  # noqa: D102


@dataclass(frozen=True, slots=True)
class ParetoPoint:
    """An entry in the plot."""

    name: str
    x: float  # [%] from the left
    y: float  # [%] from the top
    is_baseline: bool
    is_best: bool  # on the front
    label: Label | None  # of the front, where there is room


@dataclass(frozen=True, slots=True)
class ParetoPlot:
    """An error over its cost: all entries, and those that no other one beats in both."""

    error: Metric
    cost: Metric
    across: Axis  # of the cost
    upward: Axis  # of the error
    points: Sequence[ParetoPoint]
    front: Sequence[ParetoPoint]  # of the points, in order

    @property
    def steps(self) -> list[tuple[ParetoPoint, ParetoPoint]]:
        """The neighbours of the front, between which its line is drawn."""
        return list(pairwise(self.front))


def score_axis(ranks: Sequence[OnAxis], marks: Sequence[OnAxis], *, whole: bool) -> Axis:
    """Return the axis of the intervals of a leaderboard.

    It is zoomed to the rows of people; with `whole`, or without any, it has all marks too.
    """
    people = [rank for rank in ranks if not rank.is_baseline]
    shown = [*ranks, *marks] if whole or not people else people
    ends = [end for rank in shown for end in (rank.low, rank.high, rank.score)]
    if not ends:
        return Axis.over(())
    spare = 0.04 * (max(ends) - min(ends))
    return Axis.over([min(ends) - spare, max(ends) + spare])


def pareto_plot(
    entries: Sequence[tuple[str, Plotted]], front: Sequence[Measured], pair: tuple[Metric, Metric]
) -> ParetoPlot | None:
    """Return the plot of the entries that have both metrics; None with fewer than two.

    Parameters
    ----------
    entries
        With their names.
    front
        Those of them that no other one beats in both, in order.
    """
    error, cost = pair
    known = [
        (name, entry)
        for name, entry in entries
        if error.name in entry.metrics and cost.name in entry.metrics
    ]
    if len(known) < 2:
        return None
    across = Axis.over((one.metrics[cost.name] for _, one in known), logarithmic=True)
    upward = Axis.over((one.metrics[error.name] for _, one in known), logarithmic=True)
    order = {id(entry): place for place, entry in enumerate(front)}
    at = [
        Point(
            across.at(entry.metrics[cost.name]),
            upward.up(entry.metrics[error.name]),
            _short(name) if id(entry) in order else "",
        )
        for name, entry in known
    ]
    points = [
        ParetoPoint(name, point.x, point.y, entry.is_baseline, bool(point.text), label)
        for (name, entry), point, label in zip(known, at, label_placement.place(at), strict=True)
    ]
    best = {
        order[id(entry)]: point
        for (_, entry), point in zip(known, points, strict=True)
        if id(entry) in order
    }
    return ParetoPlot(error, cost, across, upward, points, [best[at] for at in sorted(best)])


def _short(name: str) -> str:
    """Return the name of a reference entry without what explains it."""
    return name.partition(":")[0]


def _step(least: float) -> float:
    """Return 1, 2 or 5 times a power of ten, at least so much."""
    unit = 10.0 ** math.floor(math.log10(least))
    return next(unit * factor for factor in _STEPS if unit * factor >= least * (1.0 - 1e-9))


def _powers(low: float, high: float) -> list[float]:
    """Return 1, 2 and 5 times powers of ten between two values; fewer if there are many."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for factors in ((1.0, 2.0, 5.0), (1.0,)):
        ticks = [factor * 10.0**k for k in decades for factor in factors]
        ticks = [float(f"{value:.3g}") for value in ticks if low <= value <= high]
        if len(ticks) <= TICKS + 1:
            return ticks
    return ticks[:: math.ceil(len(ticks) / TICKS)]
