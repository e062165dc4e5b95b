"""Whether residuals are white, which the plain intervals of least squares take for granted."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from seamark.identification.series import CHANNELS
from seamark.sim.numerics.arrays import Array

_CHANCE = 0.01  # that white residuals of a log are taken for others
_FEWEST = 30  # pairs of readings of a channel


def correlations(residuals: Array, windows: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return the correlation of successive readings of each channel, and how many pairs, (9,).

    Only readings of one window are paired. The correlation is nan of fewer than 30 pairs.
    """
    products, squares = np.zeros(len(CHANNELS)), np.zeros(len(CHANNELS))
    pairs, count = np.zeros(len(CHANNELS)), np.zeros(len(CHANNELS))
    for first, after in windows.tolist():
        for at in range(len(CHANNELS)):
            own = residuals[first:after, at]
            own = own[np.isfinite(own)]
            products[at] += own[1:] @ own[:-1]
            squares[at] += own @ own
            pairs[at] += max(len(own) - 1, 0)
            count[at] += len(own)
    enough = (pairs >= _FEWEST) & (squares > 0.0)
    out = np.full(len(CHANNELS), np.nan)
    out[enough] = products[enough] / pairs[enough] / (squares[enough] / count[enough])
    return out, pairs


def is_white(residuals: Array, windows: NDArray[np.int64]) -> bool:
    """Return whether no channel's residuals follow the ones before them.

    One-sided, since only a positive correlation makes intervals too short; 1 % over all channels.
    """
    found, pairs = correlations(residuals, windows)
    tested = np.isfinite(found)
    if not tested.any():
        return True
    limit = NormalDist().inv_cdf(1.0 - _CHANCE / int(tested.sum()))
    return bool((found[tested] * np.sqrt(pairs[tested]) < limit).all())
