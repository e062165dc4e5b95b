"""Sparse optical flow by Lucas and Kanade on a pyramid, compiled (Bouguet 2001).

OpenCV's chooses its code by the processor, so its last bits depend on that.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.arrays import Array
from seamark.sim.trackers.bilinear import grey_between

LEVELS = 4  # E: with the image itself; follows some 20 px
HALF_WINDOW_PX = 4  # S: half of Kalal's window
MOST_ITERATIONS = 10  # E: for each level, as for `klt`
STOP_PX = 0.03
LEAST_CONTRAST = 1e-3  # E: [grey²/px²] smallest eigenvalue of a point whose motion can be told
Pyramid = tuple[Array, Array, Array, Array]


def pyramid(image: NDArray[np.uint8]) -> Pyramid:
    """Return the image and three coarser ones, each half as large."""
    first = image.astype(np.float64)
    second = halved(first)
    third = halved(second)
    return first, second, third, halved(third)


@njit(cache=True, error_model="numpy")
def halved(image: Array) -> Array:
    """Return the means of 2 x 2 pixels; an odd last row or column is left out."""
    rows, columns = max(image.shape[0] // 2, 1), max(image.shape[1] // 2, 1)
    half = np.empty((rows, columns))
    for row in range(rows):
        below = min(2 * row + 1, image.shape[0] - 1)
        for column in range(columns):
            right = min(2 * column + 1, image.shape[1] - 1)
            above = image[2 * row, 2 * column] + image[2 * row, right]
            half[row, column] = 0.25 * (above + image[below, 2 * column] + image[below, right])
    return half


@njit(cache=True, error_model="numpy")
def follow(old: Pyramid, new: Pyramid, points: Array, ends: Array) -> None:
    """Write where points (n, 2) [px] of the old image are in the new one; NaN if it cannot be told.

    A point that is NaN stays NaN.
    """
    height, width = new[0].shape
    for at in range(points.shape[0]):
        x, y = points[at]
        right = down = 0.0
        for level in range(LEVELS - 1, -1, -1):
            if math.isfinite(x + y + right + down):
                scale = 1.0 / (1 << level)
                place = ((x + 0.5) * scale - 0.5, (y + 0.5) * scale - 0.5)
                right, down = _refined(old[level], new[level], place, (2.0 * right, 2.0 * down))
        ends[at, 0], ends[at, 1] = x + right, y + down
        if not (0.0 <= ends[at, 0] < width and 0.0 <= ends[at, 1] < height):
            ends[at] = math.nan


@njit(cache=True, error_model="numpy")
def _refined(
    old: Array, new: Array, place: tuple[float, float], guess: tuple[float, float]
) -> tuple[float, float]:
    """Return the motion of a point on one level, from a guess [px]: the guess without contrast."""
    x, y = place
    right, down = guess
    size = 2 * HALF_WINDOW_PX + 1
    values, across, along = np.empty(size * size), np.empty(size * size), np.empty(size * size)
    xx = xy = yy = 0.0
    for k in range(size * size):
        u, v = x + k % size - HALF_WINDOW_PX, y + k // size - HALF_WINDOW_PX
        values[k] = grey_between(old, u, v)
        across[k] = 0.5 * (grey_between(old, u + 1.0, v) - grey_between(old, u - 1.0, v))
        along[k] = 0.5 * (grey_between(old, u, v + 1.0) - grey_between(old, u, v - 1.0))
        xx += across[k] * across[k]
        xy += across[k] * along[k]
        yy += along[k] * along[k]
    least = 0.5 * (xx + yy - math.sqrt((xx - yy) * (xx - yy) + 4.0 * xy * xy))
    if not least > LEAST_CONTRAST * size * size:
        return guess
    determinant = xx * yy - xy * xy
    for _ in range(MOST_ITERATIONS):
        by_x = by_y = 0.0
        for k in range(size * size):
            u, v = x + k % size - HALF_WINDOW_PX, y + k // size - HALF_WINDOW_PX
            rest = values[k] - grey_between(new, u + right, v + down)
            by_x += rest * across[k]
            by_y += rest * along[k]
        step_x = (yy * by_x - xy * by_y) / determinant
        step_y = (xx * by_y - xy * by_x) / determinant
        right, down = right + step_x, down + step_y
        if not math.isfinite(right + down):
            return math.nan, math.nan
        if step_x * step_x + step_y * step_y < STOP_PX * STOP_PX:
            break
    return right, down


@njit(cache=True, error_model="numpy")
def _similarity(old: Array, new: Array, start: Array, end: Array) -> float:
    """Return the normalised correlation of the surroundings of two points, -1 to 1; 0 for none."""
    size = 2 * HALF_WINDOW_PX + 1
    a = b = aa = bb = ab = 0.0
    for k in range(size * size):
        right, down = k % size - HALF_WINDOW_PX, k // size - HALF_WINDOW_PX
        first = grey_between(old, start[0] + right, start[1] + down)
        second = grey_between(new, end[0] + right, end[1] + down)
        a, b = a + first, b + second
        aa, bb, ab = aa + first * first, bb + second * second, ab + first * second
    count = size * size
    both = (aa - a * a / count) * (bb - b * b / count)
    return (ab - a * b / count) / math.sqrt(both) if both > 1e-9 else 0.0


@njit(cache=True, error_model="numpy")
def similarities(old: Array, new: Array, starts: Array, ends: Array) -> Array:
    """Return how alike the surroundings of points (n, 2) are in both images, (n,)."""
    alike = np.zeros(starts.shape[0])
    for at in range(starts.shape[0]):
        if math.isfinite(ends[at, 0]):
            alike[at] = _similarity(old, new, starts[at], ends[at])
    return alike
