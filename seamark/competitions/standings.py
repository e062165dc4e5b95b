"""The ranks of a final: from the scores of all finalists on the same trials.

What a trial has in common for all of them, such as a strong current, cancels out in the difference
of two finalists, trial by trial. So Student's t test of these differences separates them with far
fewer trials than a comparison of their means (`./run performance finals` measures both).

The true rank of a finalist is 1 plus the number of those whose expected score is higher. Each is
compared with the other n - 1; those that are significantly better or worse bound its rank: a
marginal confidence set for a rank (Mogstad, Romano, Shaikh & Wilhelm 2024,
https://doi.org/10.1093/restud/rdad006). A final looks at the scores after each batch of trials and
may end there. The error of 5 % of a range is therefore divided among the n - 1 comparisons and
among all looks that there may be (Bonferroni): whenever the final ends, and for whatever reason,
its range contains the true rank with at least 95 %.
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.statistics import CONFIDENCE, block_means, mean, mean_interval
from seamark.sim.numerics.student_t import quantile

_ROUNDING = 1e-12  # of the largest score: smaller differences are errors of rounding


class Ties(StrEnum):
    """What places those get that the trials do not tell apart."""

    EARLIER = "earlier"  # in order of score; of equal scores, the earlier submission first
    SHARED = "shared"  # 1 plus the number of those that are significantly better


@dataclass(frozen=True, slots=True, kw_only=True)
class Finalist:
    """An entry of the final and its scores so far."""

    key: int  # by which the caller knows it
    submitted_at: float  # [s] since any moment
    scores: Sequence[float] | None  # of each trial, in their order; None: it failed


@dataclass(frozen=True, slots=True, kw_only=True)
class Placing:
    """The place of a finalist, and the ranks that the trials leave possible; None: it failed."""

    key: int
    place: int | None = None
    place_low: int | None = None  # the best rank that is possible
    place_high: int | None = None
    score: float | None = None
    # The 95 % interval of a score as everywhere: no place depends on it. Also None if there are
    # fewer than two blocks of trials.
    score_low: float | None = None
    score_high: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Standings:
    """The places of all finalists, the best first; those that failed come last.

    `separated` says that more trials would change nothing: each finalist is significantly better or
    worse than each other one, except those that have exactly the same scores. Two copies of a
    program do: they differ by nothing on the same trials, now and on any further ones, so the tie
    rule orders them and the final need not wait for them. Their ranges still contain the ranks of
    both.
    """

    placings: tuple[Placing, ...]
    separated: bool


def decide(finalists: Sequence[Finalist], *, block: int, looks: int, ties: Ties) -> Standings:
    """Return the places after a batch, and whether the final can end.

    Parameters
    ----------
    finalists
        In any order. Those that failed are not compared with any other.
    block
        Number of consecutive trials whose mean is one observation: `RankedProtocol.block`.
    looks
        The largest number of batches that this final may have, however many there were.

    Raises
    ------
    ValueError
        If two finalists have the same key, if they have different numbers of trials, none or
        incomplete blocks, if a score is not finite, or if `block` or `looks` is less than 1.
    """
    _check(finalists, block, looks)
    ran = [one for one in finalists if one.scores is not None]
    scores = [mean(one.scores or ()) for one in ran]
    means = [block_means(one.scores or (), block) for one in ran]
    intervals = [mean_interval(one.scores or (), block=block) or (None, None) for one in ran]
    better, separated = _compared(means, looks)
    low = 1 + np.sum(better, axis=0)  # better[i, j]: i is better than j
    high = len(ran) - np.sum(better, axis=1)
    order = sorted(
        range(len(ran)),
        key=lambda at: (
            int(low[at]) if ties == Ties.SHARED else 0,
            -scores[at],
            ran[at].submitted_at,
            ran[at].key,
        ),
    )
    placings = [
        Placing(
            key=ran[at].key,
            place=int(low[at]) if ties == Ties.SHARED else place,
            place_low=int(low[at]),
            place_high=int(high[at]),
            score=scores[at],
            score_low=intervals[at][0],
            score_high=intervals[at][1],
        )
        for place, at in enumerate(order, 1)
    ]
    failed = sorted((one.submitted_at, one.key) for one in finalists if one.scores is None)
    placings += [Placing(key=key) for _, key in failed]
    return Standings(placings=tuple(placings), separated=separated)


def _check(finalists: Sequence[Finalist], block: int, looks: int) -> None:
    if block < 1 or looks < 1:
        raise ValueError(f"block and looks must be at least 1, not {block} and {looks}")
    twice = [key for key, count in Counter(one.key for one in finalists).items() if count > 1]
    if twice:
        raise ValueError(f"finalist {twice[0]} occurs twice")
    ran = [one for one in finalists if one.scores is not None]
    trials = {len(one.scores or ()) for one in ran}
    if len(trials) > 1:
        raise ValueError(f"finalists have different numbers of trials: {sorted(trials)}")
    if any(count == 0 or count % block for count in trials):
        raise ValueError(f"{max(trials)} trials are not complete blocks of {block}")
    for one in ran:
        if not all(map(math.isfinite, one.scores or ())):
            raise ValueError(f"a score of finalist {one.key} is not finite")


def _compared(means: list[list[float]], looks: int) -> tuple[NDArray[np.bool_], bool]:
    """Return who is significantly better than whom, and whether no pair is left to tell apart.

    The arrays add and multiply element by element, and the sums are those of `math.fsum`: neither
    depends on the processor.
    """
    count, blocks = len(means), len(means[0]) if means else 0
    better = np.zeros((count, count), np.bool_)
    if count < 2 or blocks < 2:
        return better, count < 2
    table = np.array(means)
    rounding = _ROUNDING * float(np.max(np.abs(table)))
    probability = 0.5 * (1.0 - CONFIDENCE) / ((count - 1) * looks)
    critical = quantile(probability, blocks - 1.0)
    separated = True
    for at in range(count - 1):
        differences = table[at] - table[at + 1 :]
        centres = _sums(differences) / blocks
        deviations = differences - centres[:, None]
        errors = np.sqrt(_sums(deviations * deviations) / blocks) / math.sqrt(blocks - 1)
        margins = critical * errors + rounding
        if 0.5**blocks > probability:
            # Differences that are all the same, as scores that count successes may have by chance,
            # show no spread for a t test. Then a sign test has to be significant as well.
            margins[errors <= rounding] = math.inf
        better[at, at + 1 :] = centres > margins
        better[at + 1 :, at] = -centres > margins
        apart = (np.abs(centres) > margins) | ~np.any(differences, axis=1)
        separated = separated and bool(np.all(apart))
    return better, separated


def _sums(rows: Array) -> Array:
    return np.array([math.fsum(row) for row in rows.tolist()])
