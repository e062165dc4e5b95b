"""Statistics of results, with exact sums, so that no bit depends on the processor."""

import math
from collections.abc import Sequence

import numpy as np

RESAMPLES = 4000
CONFIDENCE = 0.95
BOOTSTRAP_SEED = 20_100_801  # fixed: the same scores always give the same interval


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


def bootstrap_interval(values: Sequence[float]) -> tuple[float, float] | None:
    """Return the 95 % percentile bootstrap interval of the mean; None for fewer than two."""
    if len(values) < 2:
        return None
    generator = np.random.Generator(np.random.PCG64(BOOTSTRAP_SEED))
    picks = generator.integers(len(values), size=(RESAMPLES, len(values)))
    ordered = sorted(values)  # the order in which trials end does not matter
    means = [math.fsum(ordered[i] for i in row) / len(values) for row in picks.tolist()]
    margin = 0.5 * (1.0 - CONFIDENCE)
    return percentile(means, margin), percentile(means, 1.0 - margin)
