"""Per-pixel loops of the template tracker: sample a patch of an image, smooth it, measure it.

A patch has a rim of one pixel around the template's pixels, for its gradient. Its rows are whole
vectors (numerics/simd.py) and one more; values beyond the last column are masked.
"""

import math
from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.simd import (
    WIDTH,
    f32x16,
    fma,
    horizontal_sum,
    i32x16,
    load,
    load_bits,
    load_pair,
    maximum,
    minimum,
    store,
    store_i32,
    to_f32,
    to_i32,
)
from seamark.sim.numerics.stack import on_stack
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.trackers.interface import Window

if TYPE_CHECKING:
    from seamark.sim.numerics.simd import F32x16

Plane = NDArray[np.float32]
Matrix = NDArray[np.float64]
Image = NDArray[np.uint8] | NDArray[np.uint16]  # coarser levels are sums of pixels

NUMBERS, XS, MASK = 0, 1, 2  # rows of a level's columns: 0, 1, 2...; normalised; 1 inside, 0 beyond

_PIECE = 128  # [px] of a row that is sampled at once
SMOOTH_SUM = 16  # of the weights of the 3x3 binomial mask


@uncounted
def _gather(image: Image, at: NDArray[np.int32], words: NDArray[np.uint32], length: int) -> None:
    """Write the pixels at the first flat indices, their right neighbours, and both pixels below.

    Four pixels of eight bits fill a word of the first row; of wider pixels the lower two go into
    the second row. A separate scalar loop, since scattered pixels are loaded one by one anyway.
    """
    pitch = image.shape[1]
    for c in range(length):
        upper, lower = load_pair(image, at[c]), load_pair(image, at[c] + pitch)
        if image.itemsize == 1:
            words[0, c] = upper | lower << 16
        else:
            words[0, c] = upper
            words[1, c] = lower


@uncounted
def warp_patch(
    image: Image, bounds: NDArray[np.float64], m: Matrix, unit: float, columns: Plane, out: Plane
) -> None:
    """Write out[r, c] = unit times the image at m (c - 1, r - 1, 1), bilinear.

    Parameters
    ----------
    bounds : (4,)
        x0, y0, x1, y1 [px]: samples outside take the value at the border.
    columns : (3, width)
        Only the column numbers are read.
    """
    at, words = on_stack(np.int32, _PIECE), on_stack(np.uint32, 2, _PIECE)
    fractions = on_stack(np.float32, 2, _PIECE)
    bits = 8 * image.itemsize
    below, low = (0, 16) if bits == 8 else (1, 0)  # where _gather writes the lower pixels
    one, least, value = f32x16(1.0), f32x16(1e-3), f32x16(unit)
    low_u, low_v = f32x16(bounds[0]), f32x16(bounds[1])
    high_u, high_v = f32x16(bounds[2] - 1.001), f32x16(bounds[3] - 1.001)
    across_u, across_v, across_z = f32x16(m[0, 0]), f32x16(m[1, 0]), f32x16(m[2, 0])
    pitch, end = i32x16(image.shape[1]), out.shape[1] - WIDTH
    for place in range(out.shape[0] * ((end + _PIECE - 1) // _PIECE)):
        r, begin = place % out.shape[0], place // out.shape[0] * _PIECE
        y, length = r - 1.0, min(_PIECE, end - begin)
        u0 = f32x16(m[0, 1] * y + m[0, 2] - m[0, 0])
        v0 = f32x16(m[1, 1] * y + m[1, 2] - m[1, 0])
        z0 = f32x16(m[2, 1] * y + m[2, 2] - m[2, 0])
        for c in range(0, length, WIDTH):
            column = load(columns, NUMBERS, begin + c)
            scale = one / maximum(fma(across_z, column, z0), least)
            u = minimum(maximum(fma(across_u, column, u0) * scale, low_u), high_u)
            v = minimum(maximum(fma(across_v, column, v0) * scale, low_v), high_v)
            left, above = to_i32(u), to_i32(v)
            store(fractions, 0, c, u - to_f32(left))
            store(fractions, 1, c, v - to_f32(above))
            store_i32(at, c, above * pitch + left)
        _gather(image, at, words, length)
        for c in range(0, length, WIDTH):
            fu = load(fractions, 0, c)
            a, d = load_bits(words, 0, c, 0, bits), load_bits(words, below, c, low, bits)
            over = fma(fu, load_bits(words, 0, c, bits, bits) - a, a)
            under = fma(fu, load_bits(words, below, c, low + bits, bits) - d, d)
            store(out, r, begin + c, value * fma(load(fractions, 1, c), under - over, over))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _smooth(raw: Plane, row: int, column: int) -> "F32x16":
    """Return sixteen pixels smoothed along the row."""
    sides = load(raw, row, column - 1) + load(raw, row, column + 1)
    return fma(f32x16(0.25), sides, f32x16(0.5) * load(raw, row, column))


@uncounted
def blur(raw: Plane, width: int, out: Plane) -> None:
    """Write a patch smoothed with the 3x3 binomial mask; its outermost pixels are smoothed less.

    `width` is the patch's own width, rim included. The loop goes down the columns: each row
    that is smoothed along is used three times from registers.
    """
    quarter, half = f32x16(0.25), f32x16(0.5)
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


@uncounted
def halve(image: Image, x0: int, y0: int, part: Window, out: NDArray[np.uint16]) -> None:
    """Write the sums of 2x2 blocks from column x0 and row y0 on; exact, also for sums of sums.

    `part` are the first column and row of `out` that are written, and those after the last.
    """
    first, columns = x0 + 2 * part[0], part[2] - part[0]
    for r in range(part[1], part[3]):
        upper = image[y0 + 2 * r, first : first + 2 * columns]
        lower = image[y0 + 2 * r + 1, first : first + 2 * columns]
        row = out[r, part[0] : part[2]]
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
def smooth_window(image: Image, x0: int, y0: int, part: Window, out: NDArray[np.uint16]) -> None:
    """Write SMOOTH_SUM times the image from column x0 and row y0 on, smoothed.

    The mask is the 3x3 binomial; the sums are exact. `part` is as in `halve`; pixels at its rim
    count again for those beyond.
    """
    begin, columns = x0 + part[0], part[2] - part[0]
    sums = np.empty(columns + 2, np.uint16)
    inner = sums[1 : columns + 1]
    for r in range(part[1], part[3]):
        above = image[y0 + max(r - 1, part[1]), begin : begin + columns]
        middle = image[y0 + r, begin : begin + columns]
        below = image[y0 + min(r + 1, part[3] - 1), begin : begin + columns]
        for c in range(columns):
            inner[c] = np.uint16(
                np.uint32(above[c]) + np.uint32(2) * np.uint32(middle[c]) + np.uint32(below[c])
            )
        sums[0], sums[columns + 1] = sums[1], sums[columns]
        left, right, row = sums[:columns], sums[2:], out[r, part[0] : part[2]]
        for c in range(columns):
            row[c] = np.uint16(
                np.uint32(left[c]) + np.uint32(2) * np.uint32(inner[c]) + np.uint32(right[c])
            )


@uncounted
def moments(patch: Plane, columns: Plane, count: int) -> tuple[float, float]:
    """Return mean and standard deviation [grey] of a patch without its rim.

    `count` is the number of pixels inside.
    """
    rows, end = patch.shape[0] - 2, patch.shape[1] - WIDTH
    sums = f32x16(0.0)
    for c in range(0, end, WIDTH):
        inside = f32x16(0.0)
        for r in range(1, rows + 1):
            inside = inside + load(patch, r, c + 1)
        sums = sums + inside * load(columns, MASK, c)
    mean = float(horizontal_sum(sums)) / count
    middle = f32x16(mean)
    sums = f32x16(0.0)
    for c in range(0, end, WIDTH):
        inside = f32x16(0.0)
        for r in range(1, rows + 1):
            off = load(patch, r, c + 1) - middle
            inside = fma(off, off, inside)
        sums = sums + inside * load(columns, MASK, c)
    return mean, math.sqrt(float(horizontal_sum(sums)) / count)


@uncounted
def correlation(
    patch: Plane, template: Plane, columns: Plane, count: int, own: tuple[float, float]
) -> float:
    """Return the zero-mean normalised correlation of a patch with the template.

    For two signals of equal mean and variance it is 1 - mean square difference / (2 variance).
    `own` is the template's mean and standard deviation.
    """
    m, s = moments(patch, columns, count)
    if s < 1e-3:
        return 0.0
    mean, sigma = own
    gain, bias = f32x16(sigma / s), f32x16(mean - sigma / s * m)
    products = f32x16(0.0)
    for c in range(0, patch.shape[1] - WIDTH, WIDTH):
        inside = f32x16(0.0)
        for r in range(patch.shape[0] - 2):
            off = load(template, r, c) - fma(gain, load(patch, r + 1, c + 1), bias)
            inside = fma(off, off, inside)
        products = products + inside * load(columns, MASK, c)
    return float(1.0 - float(horizontal_sum(products)) / count / (2.0 * sigma * sigma))
