"""Statistics of features as LeRobot has them, of each episode and of all together.

As there, a quantile of the whole is the mean of those of the episodes, by their lengths.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
Statistics = Mapping[str, NDArray[np.float64]]


def of_numbers(values: NDArray[Any]) -> dict[str, NDArray[np.float64]]:
    """Return the statistics of the columns of (n, k), each (k,); `count` is (1,)."""
    values = values.astype(np.float64)
    quantiles = np.quantile(values, list(QUANTILES.values()), axis=0)
    return {
        "min": values.min(axis=0),
        "max": values.max(axis=0),
        "mean": values.mean(axis=0),
        "std": values.std(axis=0),
        "count": np.array([float(len(values))]),
        **dict(zip(QUANTILES, quantiles, strict=True)),
    }


def of_grey_levels(histogram: NDArray[np.int64], images: int) -> dict[str, NDArray[np.float64]]:
    """Return the statistics of grey images for three channels from 0 to 1, each (3, 1, 1).

    Parameters
    ----------
    histogram : (256,)
        How many pixels have each grey level.
    """
    levels = np.arange(256) / 255.0
    pixels = histogram.sum()
    mean = (levels * histogram).sum() / pixels
    seen = levels[histogram > 0]
    below = np.cumsum(histogram)
    numbers = {
        "min": seen[0],
        "max": seen[-1],
        "mean": mean,
        "std": np.sqrt(((levels - mean) ** 2 * histogram).sum() / pixels),
        **{name: levels[np.searchsorted(below, q * pixels)] for name, q in QUANTILES.items()},
    }
    return {name: np.full((3, 1, 1), value) for name, value in numbers.items()} | {
        "count": np.array([float(images)])
    }


class Total:
    """The statistics of all episodes together, from those of each."""

    def __init__(self) -> None:
        self._count: Any = 0.0
        self._sums: dict[str, Any] = {}  # of means and quantiles, and of squares as "square"
        self._least: Any = np.inf
        self._most: Any = -np.inf

    def add(self, statistics: Statistics) -> None:
        """Add those of an episode."""
        count, mean = statistics["count"], statistics["mean"]
        parts = {name: statistics[name] for name in ("mean", *QUANTILES)}
        parts["square"] = statistics["std"] ** 2 + mean**2
        for name, value in parts.items():
            self._sums[name] = self._sums.get(name, 0.0) + count * value
        self._count = self._count + count
        self._least = np.minimum(self._least, statistics["min"])
        self._most = np.maximum(self._most, statistics["max"])

    def statistics(self) -> dict[str, list[Any]]:
        """Return them as plain JSON values."""
        means = {name: value / self._count for name, value in self._sums.items()}
        spread = np.sqrt(np.maximum(means.pop("square") - means["mean"] ** 2, 0.0))
        whole = {"min": self._least, "max": self._most, **means, "std": spread}
        plain = {name: np.asarray(value).tolist() for name, value in whole.items()}
        return plain | {"count": [int(self._count[0])]}
