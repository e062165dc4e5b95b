"""How sure a rank is: the ranks that a row may have, given the uncertainty of all scores.

The true rank of a row is 1 plus the number of rows whose expected score is higher. Every other row
is compared with it by Welch's t test; those that are significantly better or worse bound its rank.
The errors of these n - 1 tests together are at most 5 % (Bonferroni), so that the range covers the
true rank with at least 95 %: a marginal confidence set for a rank (Mogstad, Romano, Shaikh &
Wilhelm 2024, https://doi.org/10.1093/restud/rdad006). docs/ranking.md explains it for users.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.statistics import CONFIDENCE, welch_degrees
from seamark.sim.numerics.student_t import quantile

Range = tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A score and how well it is known."""

    score: float
    standard_error: float | None  # None: unknown, since there are fewer than two trials
    degrees: int  # of freedom of the standard error


@dataclass(frozen=True, kw_only=True)
class Population:
    """The scores of all rows of a leaderboard, one by one or counted in narrow classes.

    All arrays have the same length. The scores of a class lie between `low` and `high`; its
    standard error is an upper bound. So a class makes ranges wider, never too narrow.
    """

    low: Array
    high: Array
    standard_error: Array  # infinite: unknown
    degrees: Array
    counts: NDArray[np.int64]

    @cached_property
    def size(self) -> int:
        """The number of rows."""
        return int(np.sum(self.counts))

    @cached_property
    def _spreads(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """Errors and degrees that occur, and the index of each class in them: they are few."""
        columns = np.stack([self.standard_error, np.maximum(self.degrees, 1.0)])
        (error, degrees), index = np.unique(columns, axis=1, return_inverse=True)
        return error, degrees, index.reshape(-1)

    def rank_range(self, row: Estimate) -> Range:
        """Return the best and the worst rank that are compatible with the scores.

        `row` belongs to the population. If its error is unknown, it may have any rank.
        """
        if self.size < 2 or row.standard_error is None:
            return 1, max(self.size, 1)
        errors, degrees, index = self._spreads
        own = row.standard_error, max(row.degrees, 1)
        margin = _margins(own, errors, degrees, self.size - 1)[index]
        better = int(np.sum(self.counts, where=self.low - row.score > margin))
        worse = int(np.sum(self.counts, where=row.score - self.high > margin))
        return 1 + better, self.size - worse


def rank_ranges(rows: Sequence[Estimate]) -> list[Range]:
    """Return the ranks that each row may have if there are no others."""
    scores = np.array([row.score for row in rows], dtype=float)
    errors = [math.inf if row.standard_error is None else row.standard_error for row in rows]
    population = Population(
        low=scores,
        high=scores,
        standard_error=np.array(errors, dtype=float),
        degrees=np.array([row.degrees for row in rows], dtype=float),
        counts=np.ones(len(rows), dtype=np.int64),
    )
    return list(map(population.rank_range, rows))


def _margins(own: tuple[float, float], errors: Array, degrees: Array, comparisons: int) -> Array:
    """Return the difference of scores that is significant, for each error that others have.

    `own` is a row's standard error and its degrees of freedom.
    """
    margins = np.full_like(errors, math.inf)
    known = np.isfinite(errors)
    error = np.hypot(errors[known], own[0])
    ratio = np.divide(own[0], error, out=np.ones_like(error), where=error > 0.0)
    welch = welch_degrees(ratio * ratio, np.full_like(error, own[1]), degrees[known])
    margins[known] = _critical_values(welch, comparisons) * error
    return margins


def _critical_values(degrees: Array, comparisons: int) -> Array:
    """Return t for each number of degrees of freedom, rounded down: as in a printed table."""
    probability = 0.5 * (1.0 - CONFIDENCE) / _rounded_up(comparisons)
    whole = degrees.astype(np.int64)
    table = np.full(int(np.max(whole, initial=0)) + 1, math.nan)
    for each in np.flatnonzero(np.bincount(whole)):
        table[each] = quantile(probability, float(each))
    return table[whole]


def _rounded_up(comparisons: int) -> int:
    """Return a number with five significant bits, so that cached quantiles serve many sizes."""
    unit = 1 << max(comparisons.bit_length() - 5, 0)
    return -(-comparisons // unit) * unit
