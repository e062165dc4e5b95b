"""Matches binary features, and finds the similarity that most matches of a view agree on.

All pairs of matches are tried: with so few there is nothing to draw at random, as RANSAC would.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Words = NDArray[np.uint64]  # (n, 4) the 256 bits of each feature
_FARTHEST = 64  # bits by which a match may differ at most, E
_MOST = 48  # matches of a view that are tried
_INLIER_PX = 5.0  # E
_SCALES = (0.4, 1.6)  # D: px in the image per texel of a view, from the camera's altitude

_ONES = np.array([bin(k).count("1") for k in range(1 << 16)], np.uint8)


@njit(cache=True, nogil=True, error_model="numpy")
def nearest(words: Words, known: Words) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return for each feature the known one that is nearest, -1 if none is, and its distance."""
    which = np.full(words.shape[0], -1)
    distances = np.full(words.shape[0], _FARTHEST + 1)
    for k in range(words.shape[0]):
        for row in range(known.shape[0]):
            distance = 0
            for word in range(4):
                bits = words[k, word] ^ known[row, word]
                for part in range(4):
                    distance += _ONES[(bits >> np.uint64(16 * part)) & np.uint64(0xFFFF)]
                if distance >= distances[k]:
                    break
            if distance < distances[k]:
                distances[k], which[k] = distance, row
    return which, distances


@njit(cache=True, nogil=True, error_model="numpy")
def similarity(
    old: NDArray[np.float64], new: NDArray[np.float64]
) -> tuple[int, NDArray[np.float64]]:
    """Return how many matches agree on a similarity, and its a, b, x, y.

    It takes (p, q) of `old` (n, 2) to (a p - b q + x, b p + a q + y) in `new`.
    """
    count, best = min(old.shape[0], _MOST), 0
    found = np.zeros(4)
    trial = np.empty(4)
    for k in range(count):
        for m in range(k):
            dp, dq = old[m, 0] - old[k, 0], old[m, 1] - old[k, 1]
            du, dv = new[m, 0] - new[k, 0], new[m, 1] - new[k, 1]
            length = dp * dp + dq * dq
            if length < 16.0:
                continue
            a, b = (dp * du + dq * dv) / length, (dp * dv - dq * du) / length
            scale = np.sqrt(a * a + b * b)
            if scale < _SCALES[0] or scale > _SCALES[1]:
                continue
            trial[0], trial[1] = a, b
            trial[2] = new[k, 0] - a * old[k, 0] + b * old[k, 1]
            trial[3] = new[k, 1] - b * old[k, 0] - a * old[k, 1]
            inliers = _agreeing(old, new, trial, count)
            if inliers > best:
                best = inliers
                found[:] = trial
    return best, found


@njit(cache=True, nogil=True, error_model="numpy")
def _agreeing(
    old: NDArray[np.float64], new: NDArray[np.float64], fit: NDArray[np.float64], count: int
) -> int:
    inliers = 0
    for k in range(count):
        u = fit[0] * old[k, 0] - fit[1] * old[k, 1] + fit[2] - new[k, 0]
        v = fit[1] * old[k, 0] + fit[0] * old[k, 1] + fit[3] - new[k, 1]
        inliers += u * u + v * v < _INLIER_PX * _INLIER_PX
    return inliers
