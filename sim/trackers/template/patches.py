"""Per-pixel loops of the template tracker: cut a patch out of a picture, smooth it, measure it.

A patch has a rim of one pixel around the template's pixels, for its gradient. Its rows are whole
numbers of lanes (numerics/simd.py) and one more; what lies beyond the last column is masked away.
"""

import math
from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.simd import (
    WIDTH,
    fma,
    lanes,
    larger,
    load,
    pair,
    part,
    places,
    real,
    smaller,
    store,
    store_places,
    total,
    whole,
)

if TYPE_CHECKING:
    from seamark.sim.numerics.simd import Lanes

Plane = NDArray[np.float32]
Matrix = NDArray[np.float64]
Picture = NDArray[np.uint8] | NDArray[np.uint16]  # coarser levels are sums of pixels

NUMBERS, XS, MASK = 0, 1, 2  # rows of a level's columns: 0, 1, 2...; normalised; 1 inside, 0 beyond


@njit(cache=True, nogil=True, error_model="numpy")
def _gather(image: Picture, at: NDArray[np.int32], words: NDArray[np.uint32]) -> None:
    """Write the pixels at flat places, their right neighbours, and both of the row below.

    Four pixels of eight bits make a word of the first row; of wider ones the lower two make one of
    the second. A loop of its own between the vectors' ones: a processor loads scattered places one
    by one.
    """
    pitch = image.shape[1]
    for c in range(at.shape[0]):
        upper, lower = pair(image, at[c]), pair(image, at[c] + pitch)
        if image.itemsize == 1:
            words[0, c] = upper | lower << 16
        else:
            words[0, c] = upper
            words[1, c] = lower


@njit(cache=True, nogil=True, error_model="numpy")
def warp_patch(
    image: Picture, bounds: NDArray[np.float64], m: Matrix, unit: float, columns: Plane, out: Plane
) -> None:
    """Write out[r, c] = unit times the image at m (c - 1, r - 1, 1), bilinear.

    Parameters
    ----------
    bounds : (4,)
        x0, y0, x1, y1 [px]: samples outside take the border's value, whatever lies beyond it.
    columns : (3, width)
        Only the numbers of the columns are read.
    """
    end = out.shape[1] - WIDTH
    at = np.empty(end, np.int32)
    words = np.empty((2, end), np.uint32)
    fractions = np.empty((2, end), np.float32)
    bits = 8 * image.itemsize
    below, low = (0, 16) if bits == 8 else (1, 0)  # where _gather puts the lower pixels
    one, least, value = lanes(1.0), lanes(1e-3), lanes(unit)
    low_u, low_v = lanes(bounds[0]), lanes(bounds[1])
    high_u, high_v = lanes(bounds[2] - 1.001), lanes(bounds[3] - 1.001)
    across_u, across_v, across_z = lanes(m[0, 0]), lanes(m[1, 0]), lanes(m[2, 0])
    pitch = places(image.shape[1])
    for r in range(out.shape[0]):
        y = r - 1.0
        u0 = lanes(m[0, 1] * y + m[0, 2] - m[0, 0])
        v0 = lanes(m[1, 1] * y + m[1, 2] - m[1, 0])
        z0 = lanes(m[2, 1] * y + m[2, 2] - m[2, 0])
        for c in range(0, end, WIDTH):
            column = load(columns, NUMBERS, c)
            scale = one / larger(fma(across_z, column, z0), least)
            u = smaller(larger(fma(across_u, column, u0) * scale, low_u), high_u)
            v = smaller(larger(fma(across_v, column, v0) * scale, low_v), high_v)
            left, above = whole(u), whole(v)
            store(fractions, 0, c, u - real(left))
            store(fractions, 1, c, v - real(above))
            store_places(at, c, above * pitch + left)
        _gather(image, at, words)
        for c in range(0, end, WIDTH):
            fu = load(fractions, 0, c)
            a, d = part(words, 0, c, 0, bits), part(words, below, c, low, bits)
            over = fma(fu, part(words, 0, c, bits, bits) - a, a)
            under = fma(fu, part(words, below, c, low + bits, bits) - d, d)
            store(out, r, c, value * fma(load(fractions, 1, c), under - over, over))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _smooth(raw: Plane, row: int, column: int) -> "Lanes":
    """Return sixteen pixels smoothed along their row."""
    sides = load(raw, row, column - 1) + load(raw, row, column + 1)
    return fma(lanes(0.25), sides, lanes(0.5) * load(raw, row, column))


@njit(cache=True, nogil=True, error_model="numpy")
def blur(raw: Plane, width: int, out: Plane) -> None:
    """Write a patch smoothed with the 3x3 binomial mask; its outermost pixels are smoothed less.

    `width` is the patch's own width, rim included. The loop goes down the columns: a row that is
    smoothed along serves three times without memory in between.
    """
    quarter, half = lanes(0.25), lanes(0.5)
    last = raw.shape[0] - 1
    for c in range(1, width - 1, WIDTH):
        above, middle = _smooth(raw, 0, c), _smooth(raw, 1, c)
        store(out, 0, c, above)
        for r in range(1, last):
            under = _smooth(raw, r + 1, c)
            store(out, r, c, fma(quarter, above + under, half * middle))
            above = middle
            middle = under
        store(out, last, c, middle)
    for c in (0, width - 1):
        out[0, c], out[last, c] = raw[0, c], raw[last, c]
        for r in range(1, last):
            ends = np.float32(0.25) * (raw[r - 1, c] + raw[r + 1, c])
            out[r, c] = ends + np.float32(0.5) * raw[r, c]


@njit(cache=True, nogil=True, error_model="numpy")
def halve(image: Picture, x0: int, y0: int, out: NDArray[np.uint16]) -> None:
    """Write the sums of 2x2 blocks from column x0 and row y0 on: exact, also of sums of sums."""
    rows, columns = out.shape
    for r in range(rows):
        upper = image[y0 + 2 * r, x0 : x0 + 2 * columns]
        lower = image[y0 + 2 * r + 1, x0 : x0 + 2 * columns]
        row = out[r]
        for c in range(columns):
            k = np.uint64(2 * c)
            k1 = k + np.uint64(1)
            row[c] = np.uint16(
                np.uint32(upper[k])
                + np.uint32(upper[k1])
                + np.uint32(lower[k])
                + np.uint32(lower[k1])
            )


@njit(cache=True, nogil=True, error_model="numpy")
def moments(patch: Plane, columns: Plane, count: int) -> tuple[float, float]:
    """Return mean and standard deviation [grey] of a patch without its rim.

    `count` is the number of the pixels inside.
    """
    rows, end = patch.shape[0] - 2, patch.shape[1] - WIDTH
    found = lanes(0.0)
    for c in range(0, end, WIDTH):
        inside = lanes(0.0)
        for r in range(1, rows + 1):
            inside = inside + load(patch, r, c + 1)
        found = found + inside * load(columns, MASK, c)
    mean = float(total(found)) / count
    middle = lanes(mean)
    found = lanes(0.0)
    for c in range(0, end, WIDTH):
        inside = lanes(0.0)
        for r in range(1, rows + 1):
            off = load(patch, r, c + 1) - middle
            inside = fma(off, off, inside)
        found = found + inside * load(columns, MASK, c)
    return mean, math.sqrt(float(total(found)) / count)


@njit(cache=True, nogil=True, error_model="numpy")
def correlation(
    patch: Plane, template: Plane, columns: Plane, count: int, own: tuple[float, float]
) -> float:
    """Return the zero-mean normalised correlation of a patch with the template.

    For two signals of one mean and deviation it is 1 - mean square difference / (2 variance).
    `own` is the template's mean and deviation.
    """
    m, s = moments(patch, columns, count)
    if s < 1e-3:
        return 0.0
    mean, sigma = own
    gain, bias = lanes(sigma / s), lanes(mean - sigma / s * m)
    found = lanes(0.0)
    for c in range(0, patch.shape[1] - WIDTH, WIDTH):
        inside = lanes(0.0)
        for r in range(patch.shape[0] - 2):
            off = load(template, r, c) - fma(gain, load(patch, r + 1, c + 1), bias)
            inside = fma(off, off, inside)
        found = found + inside * load(columns, MASK, c)
    return float(1.0 - float(total(found)) / count / (2.0 * sigma * sigma))
