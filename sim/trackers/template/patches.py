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
    all_alike,
    f32x16,
    fma,
    horizontal_sum,
    i32x16,
    load,
    load_pairs,
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
_TWO_PIECES = 2 * _PIECE
_VECTORS = _TWO_PIECES // WIDTH
SMOOTH_SUM = 16  # of the weights of the 3x3 binomial mask


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _locate(
    m: Matrix,
    r: int,
    columns: tuple[Plane, int, int],
    limits: "tuple[F32x16, F32x16, F32x16, F32x16]",
    pitch: int,
    out: tuple[NDArray[np.int32], Plane, NDArray[np.int32], int],
) -> None:
    """Write flat indices, and fractions in u and v, of a row's samples between two columns.

    And for each vector whether its indices are all alike, as beyond a border. Of a vector with one
    column only the first is used, so they count as alike.
    """
    numbers, begin, end = columns
    at, fractions, alike, k = out
    low_u, low_v, high_u, high_v = limits
    across_u, across_v, across_z = f32x16(m[0, 0]), f32x16(m[1, 0]), f32x16(m[2, 0])
    y = r - 1.0
    u0 = f32x16(m[0, 1] * y + m[0, 2] - m[0, 0])
    v0 = f32x16(m[1, 1] * y + m[1, 2] - m[1, 0])
    z0 = f32x16(m[2, 1] * y + m[2, 2] - m[2, 0])
    for c in range(begin, end, WIDTH):
        column = load(numbers, NUMBERS, c)
        scale = f32x16(1.0) / maximum(fma(across_z, column, z0), f32x16(1e-3))
        u = minimum(maximum(fma(across_u, column, u0) * scale, low_u), high_u)
        v = minimum(maximum(fma(across_v, column, v0) * scale, low_v), high_v)
        left, above = to_i32(u), to_i32(v)
        store(fractions, 0, k, u - to_f32(left))
        store(fractions, 1, k, v - to_f32(above))
        places = above * i32x16(pitch) + left
        store_i32(at, k, places)
        alike[k // WIDTH] = all_alike(places) or c + 1 == end
        k += WIDTH


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _interpolate(
    image: Image, samples: tuple[NDArray[np.int32], Plane, NDArray[np.int32]], k: int
) -> "F32x16":
    """Return sixteen bilinear samples; k is the first one's number in what `_locate` wrote."""
    at, fractions, alike = samples
    one = alike[k // WIDTH] != 0
    bits, field = i32x16(8 * image.itemsize), i32x16((1 << 8 * image.itemsize) - 1)
    fu = load(fractions, 0, k)
    upper = load_pairs(image, 0, at, k, one)
    lower = load_pairs(image, image.shape[1], at, k, one)
    a, d = to_f32(upper & field), to_f32(lower & field)
    over = fma(fu, to_f32(upper >> bits) - a, a)
    under = fma(fu, to_f32(lower >> bits) - d, d)
    return fma(load(fractions, 1, k), under - over, over)


@uncounted
def warp_patch(
    image: Image,
    bounds: NDArray[np.float64],
    m: Matrix,
    unit: float,
    columns: tuple[Plane, int],
    out: Plane,
) -> None:
    """Write out[r, c] = unit times the image at m (c - 1, r - 1, 1), bilinear.

    First all places of two rows are stored, then their pixels are loaded one by one: in a single
    loop over both, the processor would wait for each place, which takes twice as long.

    Parameters
    ----------
    bounds : (4,)
        x0, y0, x1, y1 [px]: samples outside take the value at the border.
    columns : tuple
        Columns (3, width), of which only the numbers are read, and how many the patch has, rim
        included. Those beyond become any numbers.
    """
    at, fractions = on_stack(np.int32, _TWO_PIECES), on_stack(np.float32, 2, _TWO_PIECES)
    alike = on_stack(np.int32, _VECTORS)
    low_u, low_v = f32x16(bounds[0]), f32x16(bounds[1])
    high_u, high_v = f32x16(bounds[2] - 1.001), f32x16(bounds[3] - 1.001)
    limits = (low_u, low_v, high_u, high_v)
    numbers, width = columns
    rows, pitch, value = out.shape[0], image.shape[1], f32x16(unit)
    for begin in range(0, width, _PIECE):
        end = min(begin + _PIECE, width)
        for first in range(0, rows, 2):
            last = min(first + 2, rows)
            for r in range(first, last):
                target = (at, fractions, alike, (r - first) * _PIECE)
                _locate(m, r, (numbers, begin, end), limits, pitch, target)
            for r in range(first, last):
                k = (r - first) * _PIECE - begin
                for c in range(begin, end, WIDTH):
                    store(out, r, c, value * _interpolate(image, (at, fractions, alike), k + c))


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
def moments(patch: Plane, columns: Plane, inner: int) -> tuple[float, float]:
    """Return mean and standard deviation [grey] of a patch without its rim.

    `inner` is the number of columns inside.
    """
    rows = patch.shape[0] - 2
    count = rows * inner
    sums = f32x16(0.0)
    for c in range(0, inner, WIDTH):
        inside = f32x16(0.0)
        for r in range(1, rows + 1):
            inside = inside + load(patch, r, c + 1)
        sums = sums + inside * load(columns, MASK, c)
    mean = float(horizontal_sum(sums)) / count
    middle = f32x16(mean)
    sums = f32x16(0.0)
    for c in range(0, inner, WIDTH):
        inside = f32x16(0.0)
        for r in range(1, rows + 1):
            off = load(patch, r, c + 1) - middle
            inside = fma(off, off, inside)
        sums = sums + inside * load(columns, MASK, c)
    return mean, math.sqrt(float(horizontal_sum(sums)) / count)


@uncounted
def correlation(
    patch: Plane, template: Plane, columns: Plane, inner: int, own: tuple[float, float]
) -> float:
    """Return the zero-mean normalised correlation of a patch with the template.

    For two signals of equal mean and variance it is 1 - mean square difference / (2 variance).
    `inner` is as in `moments`, `own` the template's mean and standard deviation.
    """
    m, s = moments(patch, columns, inner)
    if s < 1e-3:
        return 0.0
    mean, sigma = own
    gain, bias = f32x16(sigma / s), f32x16(mean - sigma / s * m)
    products = f32x16(0.0)
    rows = patch.shape[0] - 2
    for c in range(0, inner, WIDTH):
        inside = f32x16(0.0)
        for r in range(rows):
            off = load(template, r + 1, c + 1) - fma(gain, load(patch, r + 1, c + 1), bias)
            inside = fma(off, off, inside)
        products = products + inside * load(columns, MASK, c)
    return float(1.0 - float(horizontal_sum(products)) / (rows * inner) / (2.0 * sigma * sigma))
