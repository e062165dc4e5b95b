"""Per-pixel loops of the template tracker, with the same bits on every processor.

A float sum depends on its order, and LLVM may only vectorise a float sum by reordering it
(`fastmath`), differently for each vector width. So products are rounded to 32-bit integers row by
row and added as integers: that is exact in any order, vectorises without `fastmath`, and what the
rounding takes is a ten-thousandth of the products that matter.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Plane = NDArray[np.float32]
Matrix = NDArray[np.float64]

TEMPLATE_SIGMA = 32.0  # [grey] contrast to which patches are scaled before their products
_F = np.float32
_GRADIENT_LIMIT = 100.0  # [grey/px] clipped beyond, so that the integer sums cannot overflow
_ERROR_LIMIT = 200.0  # [grey]
_LARGEST_SUM = float(1 << 30)
_VALUE_SCALE = 64.0  # [1/grey] of the rounded grey values in the mean


@njit(cache=True, nogil=True, error_model="numpy")
def _lerp(fractions: Plane, row: int, patch: Plane) -> None:
    """Write a row of the patch from fu, fv and the four pixels around, the rows of `fractions`."""
    r = np.uint64(row)
    for q in range(patch.shape[1]):
        fu = fractions[0, q]
        top = fractions[2, q] + fu * (fractions[3, q] - fractions[2, q])
        low = fractions[4, q] + fu * (fractions[5, q] - fractions[4, q])
        patch[r, q] = top + fractions[1, q] * (low - top)


@njit(cache=True, nogil=True, error_model="numpy")
def warp_patch(
    image: NDArray[np.uint8] | Plane,
    bounds: NDArray[np.float32],
    m: Matrix,
    patch: Plane,
    places: NDArray[np.int32],
    fractions: Plane,
) -> None:
    """Write patch[r, c] = image at m (c - 1, r - 1, 1), bilinear.

    Parameters
    ----------
    bounds : (4,)
        x0, y0, x1, y1 [px]: samples outside take the border's value, whatever lies beyond it.
    places, fractions
        Work rows (columns,) and (6, columns).
    """
    columns = patch.shape[1]
    stride = np.int32(image.shape[1])
    flat = image.ravel()
    m00 = _F(m[0, 0])
    m10 = _F(m[1, 0])
    m20 = _F(m[2, 0])
    low_u = bounds[0]
    low_v = bounds[1]
    high_u = bounds[2] - _F(1.001)
    high_v = bounds[3] - _F(1.001)
    fu = fractions[0]
    fv = fractions[1]
    four = fractions[2:]
    for r in range(patch.shape[0]):
        y = r - 1.0
        x0 = _F(m[0, 1] * y + m[0, 2] - m[0, 0])
        y0 = _F(m[1, 1] * y + m[1, 2] - m[1, 0])
        z0 = _F(m[2, 1] * y + m[2, 2] - m[2, 0])
        for c in range(columns):
            column = _F(np.int32(c))
            scale = _F(1.0) / max(z0 + m20 * column, _F(1e-3))
            u = min(max((x0 + m00 * column) * scale, low_u), high_u)
            v = min(max((y0 + m10 * column) * scale, low_v), high_v)
            iu = np.int32(u)
            iv = np.int32(v)
            fu[c] = u - _F(iu)
            fv[c] = v - _F(iv)
            places[c] = np.int32(np.int32(iv * stride) + iu)
        for c in range(columns):
            q = np.uint64(places[c])
            below = q + np.uint64(stride)
            four[0, c] = flat[q]
            four[1, c] = flat[q + np.uint64(1)]
            four[2, c] = flat[below]
            four[3, c] = flat[below + np.uint64(1)]
        _lerp(fractions, r, patch)


@njit(cache=True, nogil=True, error_model="numpy")
def blur(patch: Plane, work: Plane) -> None:
    """Smooth a patch with the 3x3 binomial mask in place; its outermost pixels stay."""
    rows, columns = patch.shape
    for r in range(rows):
        left = patch[r]
        middle = patch[r, 1:]
        right = patch[r, 2:]
        out = work[r, 1:]
        for c in range(columns - 2):
            out[c] = _F(0.25) * (left[c] + right[c]) + _F(0.5) * middle[c]
        work[r, 0] = patch[r, 0]
        work[r, columns - 1] = patch[r, columns - 1]
    for r in range(1, rows - 1):
        above = work[r - 1]
        middle = work[r]
        under = work[r + 1]
        out = patch[r]
        for c in range(columns):
            out[c] = _F(0.25) * (above[c] + under[c]) + _F(0.5) * middle[c]


@njit(cache=True, nogil=True, error_model="numpy")
def halve(image: NDArray[np.uint8], x0: int, y0: int, out: Plane) -> None:
    """Write the means of 2x2 blocks from column x0 and row y0 on."""
    rows, columns = out.shape
    for r in range(rows):
        upper = image[y0 + 2 * r, x0 : x0 + 2 * columns]
        lower = image[y0 + 2 * r + 1, x0 : x0 + 2 * columns]
        row = out[r]
        for c in range(columns):
            k = np.uint64(2 * c)
            k1 = k + np.uint64(1)
            total = (
                np.int32(upper[k]) + np.int32(upper[k1]) + np.int32(lower[k]) + np.int32(lower[k1])
            )
            row[c] = _F(0.25) * _F(np.int32(total))


@njit(cache=True, nogil=True, error_model="numpy")
def _row_sum(row: Plane, scale: float) -> int:
    s = _F(scale)
    total = np.int32(0)
    for c in range(row.shape[0]):
        total = np.int32(total + np.int32(row[c] * s + _F(0.5)))
    return int(total)


@njit(cache=True, nogil=True, error_model="numpy")
def _row_square(row: Plane, mean: float, scale: float) -> int:
    s = _F(scale)
    m = _F(mean)
    total = np.int32(0)
    for c in range(row.shape[0]):
        d = row[c] - m
        total = np.int32(total + np.int32(d * d * s + _F(0.5)))
    return int(total)


@njit(cache=True, nogil=True, error_model="numpy")
def moments(patch: Plane) -> tuple[float, float]:
    """Return mean and standard deviation [grey] of a patch without its outermost pixels."""
    rows = patch.shape[0] - 2
    columns = patch.shape[1] - 2
    total = 0
    for r in range(1, rows + 1):
        total += _row_sum(patch[r, 1 : columns + 1], _VALUE_SCALE)
    n = rows * columns
    mean = float(total) / (_VALUE_SCALE * n)
    scale = _LARGEST_SUM / (65025.0 * columns)
    total = 0
    for r in range(1, rows + 1):
        total += _row_square(patch[r, 1 : columns + 1], mean, scale)
    return mean, math.sqrt(float(total) / (scale * n))


@njit(cache=True, nogil=True, error_model="numpy")
def _row_correlation(row: Plane, template: Plane, gain: float, bias: float, scale: float) -> int:
    k = _F(gain)
    b = _F(bias)
    s = _F(scale)
    total = np.int32(0)
    for c in range(template.shape[0]):
        e = min(max(template[c] - (k * row[c] + b), _F(-_ERROR_LIMIT)), _F(_ERROR_LIMIT))
        total = np.int32(total + np.int32(e * e * s + _F(0.5)))
    return int(total)


@njit(cache=True, nogil=True, error_model="numpy")
def correlation(patch: Plane, template: Plane, mean: float, sigma: float) -> float:
    """Return the zero-mean normalised correlation of a patch with the scaled template.

    For two signals of one mean and deviation it is 1 - mean square difference / (2 variance).
    `sigma` is the template's own (TEMPLATE_SIGMA unless it is flat), `mean` its mean.
    """
    rows, columns = template.shape
    m, s = moments(patch)
    if s < 1e-3:
        return 0.0
    gain = sigma / s
    scale = _LARGEST_SUM / (_ERROR_LIMIT**2 * columns)
    total = 0
    for r in range(rows):
        total += _row_correlation(
            patch[r + 1, 1 : columns + 1], template[r], gain, mean - gain * m, scale
        )
    return float(1.0 - float(total) / (scale * rows * columns) / (2.0 * sigma * sigma))


# Columns of the Jacobian gx x, gx y, gy x, gy y, -x t, -y t, gx, gy with t = gx x + gy y, as sums
# of terms: direction of the gradient (0 x, 1 y), power of x, power of y, sign.
_JACOBIAN = (
    ((0, 1, 0, 1.0),),
    ((0, 0, 1, 1.0),),
    ((1, 1, 0, 1.0),),
    ((1, 0, 1, 1.0),),
    ((0, 2, 0, -1.0), (1, 1, 1, -1.0)),
    ((0, 1, 1, -1.0), (1, 0, 2, -1.0)),
    ((0, 0, 0, 1.0),),
    ((1, 0, 0, 1.0),),
)
# Where the sums over gx gx x^k, gx gy x^k, gy gy x^k, gx e x^k, gy e x^k start among all of them.
_SQUARES = (0, 5, 9)
_ERRORS = (12, 15)
_SUMS = 17
_POWERS = 5  # of y: 0 to 4


def _terms() -> tuple[NDArray[np.int64], Matrix]:
    """Return which sum (row, column, sum, power of y) with which sign makes up a and g.

    Column 8 stands for g.
    """
    places, signs = [], []
    for i, left in enumerate(_JACOBIAN):
        for d1, x1, y1, s1 in left:
            places.append((i, 8, _ERRORS[d1] + x1, y1))
            signs.append(s1)
            for j, right in enumerate(_JACOBIAN):
                for d2, x2, y2, s2 in right:
                    places.append((i, j, _SQUARES[d1 + d2] + x1 + x2, y1 + y2))
                    signs.append(s1 * s2)
    return np.array(places), np.array(signs)


_PLACES, _SIGNS = _terms()


@njit(cache=True, nogil=True, error_model="numpy")
def _row_squares(
    patch: Plane, gradients: Plane, xs: Plane, r: int, factors: Plane, out: NDArray[np.int64]
) -> None:
    """Write the twelve sums of products of gradients over one row.

    Only powers of x are summed here: y is the same along a row and enters once, afterwards.
    `r` is the row; `factors`: half the gradient's weight, gain, bias, integer scale. Whole planes
    come in: a view of each row would cost more than the arithmetic on it.
    """
    half = factors[0]
    s = factors[3]
    limit = _F(_GRADIENT_LIMIT)
    row, middle, lower = np.uint64(r), np.uint64(r + 1), np.uint64(r + 2)
    a0 = a1 = a2 = a3 = a4 = np.int32(0)
    b0 = b1 = b2 = b3 = np.int32(0)
    c0 = c1 = c2 = np.int32(0)
    for c in range(xs.shape[0]):
        x = xs[c]
        gx = min(
            max(half * (patch[middle, c + 2] - patch[middle, c]) + gradients[0, row, c], -limit),
            limit,
        )
        gy = min(
            max(half * (patch[lower, c + 1] - patch[row, c + 1]) + gradients[1, row, c], -limit),
            limit,
        )
        xx = gx * gx * s
        xy = gx * gy * s
        yy = gy * gy * s
        x2 = x * x
        a0 = np.int32(a0 + np.int32(xx))
        a1 = np.int32(a1 + np.int32(xx * x))
        a2 = np.int32(a2 + np.int32(xx * x2))
        a3 = np.int32(a3 + np.int32(xx * x2 * x))
        a4 = np.int32(a4 + np.int32(xx * x2 * x2))
        b0 = np.int32(b0 + np.int32(xy))
        b1 = np.int32(b1 + np.int32(xy * x))
        b2 = np.int32(b2 + np.int32(xy * x2))
        b3 = np.int32(b3 + np.int32(xy * x2 * x))
        c0 = np.int32(c0 + np.int32(yy))
        c1 = np.int32(c1 + np.int32(yy * x))
        c2 = np.int32(c2 + np.int32(yy * x2))
    out[0], out[1], out[2], out[3], out[4] = a0, a1, a2, a3, a4
    out[5], out[6], out[7], out[8] = b0, b1, b2, b3
    out[9], out[10], out[11] = c0, c1, c2


@njit(cache=True, nogil=True, error_model="numpy")
def _row_errors(
    patch: Plane,
    template: Plane,
    gradients: Plane,
    xs: Plane,
    r: int,
    factors: Plane,
    out: NDArray[np.int64],
) -> None:
    """Write the five sums of products of gradient and error; arguments as in `_row_squares`."""
    half = factors[0]
    gain = factors[1]
    bias = factors[2]
    s = factors[3]
    limit = _F(_GRADIENT_LIMIT)
    most = _F(_ERROR_LIMIT)
    row, middle, lower = np.uint64(r), np.uint64(r + 1), np.uint64(r + 2)
    d0 = d1 = d2 = e0 = e1 = np.int32(0)
    for c in range(xs.shape[0]):
        x = xs[c]
        gx = min(
            max(half * (patch[middle, c + 2] - patch[middle, c]) + gradients[0, row, c], -limit),
            limit,
        )
        gy = min(
            max(half * (patch[lower, c + 1] - patch[row, c + 1]) + gradients[1, row, c], -limit),
            limit,
        )
        error = min(max(template[row, c] - (gain * patch[middle, c + 1] + bias), -most), most) * s
        p0 = gx * error
        p1 = p0 * x
        q0 = gy * error
        d0 = np.int32(d0 + np.int32(p0))
        d1 = np.int32(d1 + np.int32(p1))
        d2 = np.int32(d2 + np.int32(p1 * x))
        e0 = np.int32(e0 + np.int32(q0))
        e1 = np.int32(e1 + np.int32(q0 * x))
    out[12], out[13], out[14], out[15], out[16] = d0, d1, d2, e0, e1


@njit(cache=True, nogil=True, error_model="numpy")
def normal_equations(
    patch: Plane,
    template: Plane,
    gradients: Plane,
    axes: tuple[Plane, Plane],
    model: tuple[float, float, float],
    a: Matrix,
    g: Matrix,
) -> None:
    """Write a (8, 8), symmetric, and g (8,) of the least-squares step a d = g.

    Parameters
    ----------
    patch : (rows + 2, columns + 2)
        Warped image with a rim of one pixel for its gradient.
    gradients : (2, rows, columns)
        The template's share of the gradient, already weighted.
    axes : tuple
        Normalised columns and rows.
    model : tuple
        weight of the patch's own gradient (0.5 ESM, 0 inverse, 1 forward compositional), gain and
        bias that turn the patch into the template's grey values.
    """
    rows, columns = template.shape
    xs, ys = axes
    weight, gain, bias = model
    scale = _LARGEST_SUM / (_GRADIENT_LIMIT * _ERROR_LIMIT * columns)
    factors = np.empty(4, np.float32)
    factors[0] = 0.5 * weight * gain
    factors[1] = gain
    factors[2] = bias
    factors[3] = scale
    sums = np.empty(_SUMS, np.int64)
    totals = np.zeros((_SUMS, _POWERS))
    for r in range(rows):
        _row_squares(patch, gradients, xs, r, factors, sums)
        _row_errors(patch, template, gradients, xs, r, factors, sums)
        power = 1.0 / scale
        for p in range(_POWERS):
            for k in range(_SUMS):
                totals[k, p] += power * sums[k]
            power *= ys[r]
    a[:] = 0.0
    g[:] = 0.0
    for t in range(_SIGNS.shape[0]):
        i, j, k, p = _PLACES[t, 0], _PLACES[t, 1], _PLACES[t, 2], _PLACES[t, 3]
        if j == 8:
            g[i] += _SIGNS[t] * totals[k, p]
        else:
            a[i, j] += _SIGNS[t] * totals[k, p]
