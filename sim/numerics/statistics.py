"""Statistics of results, with exact sums, so that no bit depends on the processor."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, TypeVar

from seamark.sim.numerics.student_t import quantile

if TYPE_CHECKING:  # each upload is read in a process of its own, which needs no NumPy
    from seamark.sim.numerics.arrays import Array

CONFIDENCE = 0.95
Number = TypeVar("Number", float, "Array")


def mean(values: Sequence[float]) -> float:
    """Return the mean; nan if there are none."""
    return math.fsum(values) / len(values) if values else math.nan


def root_mean_square(values: Sequence[float]) -> float:
    """Return the root mean square; nan if there are none."""
    return math.sqrt(mean([value * value for value in values])) if values else math.nan


def percentile(values: Sequence[float], share: float) -> float:
    """Return the quantile for a share from 0 to 1, interpolated; nan if there are none."""
    if not values:
        return math.nan
    ordered = sorted(values)
    position = share * (len(ordered) - 1)
    low = math.floor(position)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (position - low) * (ordered[high] - ordered[low])


def block_means(values: Sequence[float], block: int) -> list[float]:
    """Return the means of consecutive blocks of values; none if the last block is incomplete."""
    if len(values) % block:
        return []
    return [mean(values[at : at + block]) for at in range(0, len(values), block)]


def standard_error(values: Sequence[float]) -> float:
    """Return the standard error of the mean of independent values; nan for fewer than two."""
    if len(values) < 2:
        return math.nan
    centre = mean(values)
    deviations = [value - centre for value in values]
    return root_mean_square(deviations) / math.sqrt(len(values) - 1)


def mean_interval(values: Sequence[float], *, block: int = 1) -> tuple[float, float] | None:
    """Return the 95 % interval of the mean: Student's t over the means of consecutive blocks.

    Its coverage is nominal where the percentile bootstrap of ten trials covers only 90 %
    (`./run performance coverage`).

    Parameters
    ----------
    values
        One value of each trial, in the order of the trials.
    block
        Number of consecutive trials that are not exchangeable with each other, such as trials that
        alternate between two vehicles: their mean is one observation.

    Returns
    -------
    (float, float) or None
        None for fewer than two blocks, and if the last block is incomplete.
    """
    means = block_means(values, block)
    if len(means) < 2:
        return None
    return _around(mean(means), standard_error(means), len(means) - 1)


def difference_interval(
    first: Sequence[float], second: Sequence[float], *, block: int = 1
) -> tuple[float, float] | None:
    """Return the 95 % interval of the difference of two means, first minus second.

    Welch's t interval with the degrees of freedom of Satterthwaite: for independent samples, whose
    variances may differ. `block` and None are as in `mean_interval`.
    """
    means = [block_means(values, block) for values in (first, second)]
    if min(map(len, means)) < 2:
        return None
    errors = [standard_error(each) for each in means]
    error = math.hypot(*errors)
    ratio = errors[0] / error if error else 1.0
    degrees = welch_degrees(ratio * ratio, *(len(each) - 1.0 for each in means))
    return _around(mean(means[0]) - mean(means[1]), error, degrees)


def paired_interval(
    first: Sequence[float], second: Sequence[float], *, block: int = 1
) -> tuple[float, float] | None:
    """Return the 95 % interval of the mean difference of two runs on the same trials.

    What the trials have in common cancels out, so it is much narrower than `difference_interval`.
    """
    differences = [a - b for a, b in zip(first, second, strict=True)]
    return mean_interval(differences, block=block)


def welch_degrees(share: Number, first: Number, second: Number) -> Number:
    """Return the degrees of freedom of a difference of means (Welch 1947; Satterthwaite 1946).

    Parameters
    ----------
    share
        Of the first mean in the variance of the difference, from 0 to 1.
    first, second
        Degrees of freedom of the two means.
    """
    rest = 1.0 - share
    return 1.0 / (share * share / first + rest * rest / second)


def area(values: Sequence[float], quality: Sequence[float]) -> float:
    """Return the area under the quality over the values of the levels, by the trapezoidal rule.

    If the quality falls from 1 to 0, this is the Spearman-Karber estimate of the mean value at
    which it is lost, above the lowest level (Finney 1978, Statistical Method in Biological Assay).
    It is linear in the quality, so that the mean over trials of the area is the area under the
    mean, and no single unlucky level decides.

    Parameters
    ----------
    values
        Distinct values of the levels, in any order.
    quality
        Of each level, from 0 to 1.

    Returns
    -------
    float
        In the unit of `values`, from 0 to their range.
    """
    points = sorted(zip(values, quality, strict=True))
    return math.fsum(0.5 * (p + q) * (y - x) for (x, p), (y, q) in pairwise(points))


def _around(centre: float, error: float, degrees: float) -> tuple[float, float]:
    margin = quantile(0.5 * (1.0 - CONFIDENCE), degrees) * error
    return centre - margin, centre + margin
