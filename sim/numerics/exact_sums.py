"""Exact sums of arrays: the same bits as those of `math.fsum`, in a tenth of its time."""

import math

import numpy as np

from seamark.sim.numerics.arrays import Array

_LEAST = 1 << 1074  # the inverse of the smallest number


def exact_sum(values: Array) -> float:
    """Return the sum of an array of any shape, rounded once; as `math.fsum` if one is not finite.

    Raises
    ------
    OverflowError, ValueError
        The sum is too large; there are infinities of both signs.
    """
    from seamark.sim.numerics.sums_of_bits import BINS, add_bits  # noqa: PLC0415  # not for pages

    numbers = np.ascontiguousarray(values, np.float64).ravel()
    bins = np.zeros(BINS, np.int64)
    if not add_bits(numbers.view(np.int64), bins):
        return math.fsum(numbers.tolist())
    total = sum(int(bins[at]) << (32 * at) for at in np.flatnonzero(bins).tolist())
    return total / _LEAST


def exact_mean(values: Array) -> float:
    """Return the mean of an array of any shape; nan if it is empty."""
    return exact_sum(values) / values.size if values.size else math.nan


def exact_root_mean_square(values: Array) -> float:
    """Return the root mean square of an array of any shape; nan if it is empty."""
    return math.sqrt(exact_mean(values * values))
