"""Statistics of results: exact sums, so that the last bit does not depend on the processor."""

import math
from collections.abc import Sequence

import numpy as np

RESAMPLES = 4000
CONFIDENCE = 0.95
BOOTSTRAP_SEED = 20_100_801  # own generator: the same scores always give the same interval


def mean(values: Sequence[float]) -> float:
    """Return the mean; nan of nothing."""
    return math.fsum(values) / len(values) if values else math.nan


def root_mean_square(values: Sequence[float]) -> float:
    """Return the root of the mean square; nan of nothing."""
    return math.sqrt(mean([value * value for value in values])) if values else math.nan


def percentile(values: Sequence[float], share: float) -> float:
    """Return the value that a share (0 to 1) stays below, interpolated; nan of nothing."""
    if not values:
        return math.nan
    ordered = sorted(values)
    place = share * (len(ordered) - 1)
    low = math.floor(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (place - low) * (ordered[high] - ordered[low])


def bootstrap_interval(values: Sequence[float]) -> tuple[float, float] | None:
    """Return the 95 % percentile bootstrap interval of the mean; None of fewer than two."""
    if len(values) < 2:
        return None
    generator = np.random.Generator(np.random.PCG64(BOOTSTRAP_SEED))
    picks = generator.integers(len(values), size=(RESAMPLES, len(values)))
    ordered = sorted(values)  # the order in which trials ended makes no difference
    means = [math.fsum(ordered[i] for i in row) / len(values) for row in picks.tolist()]
    margin = 0.5 * (1.0 - CONFIDENCE)
    return percentile(means, margin), percentile(means, 1.0 - margin)
