"""Normal equations of one step: sums over all pixels of products of gradients and errors.

Columns of the Jacobian are gx x, gx y, gy x, gy y, -x t, -y t, gx, gy with t = gx x + gy y, so all
sums are of gx gx, gx gy, gy gy, gx e or gy e times powers of x and y. The loops go down sixteen
columns at once: only powers of y are summed there; x is constant and multiplied in afterwards.
One loop with all seventeen sums takes half the time of several that read the gradients again, and
as long where a processor has too few registers for that.
"""

from collections import defaultdict
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.signed_sums import signed_sums
from seamark.sim.numerics.simd import WIDTH, f32x16, fma, horizontal_sums, load, store
from seamark.sim.numerics.stack import on_stack
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.trackers.template.patches import MASK, XS, Matrix, Plane

if TYPE_CHECKING:
    from seamark.sim.numerics.simd import F32x16

# Each column as terms: direction of the gradient (0 x, 1 y), power of x, power of y, sign.
_JACOBIAN = (
    ((0, 1, 0, 1),),
    ((0, 0, 1, 1),),
    ((1, 1, 0, 1),),
    ((1, 0, 1, 1),),
    ((0, 2, 0, -1), (1, 1, 1, -1)),
    ((0, 1, 1, -1), (1, 0, 2, -1)),
    ((0, 0, 0, 1),),
    ((1, 0, 0, 1),),
)
# Index of the first of the sums over gx gx y^k, gx gy y^k, gy gy y^k, gx e y^k, gy e y^k.
_SQUARES = (0, 3, 7)
_ERRORS = (12, 14)
# Each sum times powers of x from 0 on, as many as are listed here, makes moments.
_POWERS = (5, 4, 3, 4, 4, 3, 2, 3, 3, 3, 2, 1, 3, 2, 2, 2, 1)
_FIRST = tuple(accumulate(_POWERS, initial=0))  # of each sum's moments
_MOMENTS = 48  # whole vectors; the last is not used
Terms = dict[int, list[tuple[int, int]]]  # of each number of an array: moments and their signs


def _terms() -> tuple[Terms, Terms]:
    """Return what the matrix (8, 8) and the right-hand side of the equations are made up of."""
    matrix: Terms = defaultdict(list)
    right_side: Terms = defaultdict(list)
    for i, left in enumerate(_JACOBIAN):
        for d1, x1, y1, s1 in left:
            right_side[i].append((_FIRST[_ERRORS[d1] + y1] + x1, s1))
            for j, right in enumerate(_JACOBIAN):
                for d2, x2, y2, s2 in right:
                    moment = _FIRST[_SQUARES[d1 + d2] + y1 + y2] + x1 + x2
                    matrix[8 * i + j].append((moment, s1 * s2))
    return matrix, right_side


_write_matrix, _write_right_side = (signed_sums(terms) for terms in _terms())


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _add_products(s: int, value: "F32x16", x: "F32x16", totals: Plane) -> None:
    """Add the moments that the sum of number s makes with powers of x."""
    power = f32x16(1.0)
    for k in range(_POWERS[s]):
        store(totals, _FIRST[s] + k, 0, load(totals, _FIRST[s] + k, 0) + value * power)
        power = power * x


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _add_moments(sums: "tuple[F32x16, ...]", x: "F32x16", totals: Plane) -> None:
    """Add all moments; without a loop, so the compiler knows their places and powers."""
    _add_products(0, sums[0], x, totals)
    _add_products(1, sums[1], x, totals)
    _add_products(2, sums[2], x, totals)
    _add_products(3, sums[3], x, totals)
    _add_products(4, sums[4], x, totals)
    _add_products(5, sums[5], x, totals)
    _add_products(6, sums[6], x, totals)
    _add_products(7, sums[7], x, totals)
    _add_products(8, sums[8], x, totals)
    _add_products(9, sums[9], x, totals)
    _add_products(10, sums[10], x, totals)
    _add_products(11, sums[11], x, totals)
    _add_products(12, sums[12], x, totals)
    _add_products(13, sums[13], x, totals)
    _add_products(14, sums[14], x, totals)
    _add_products(15, sums[15], x, totals)
    _add_products(16, sums[16], x, totals)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _add_strip(
    planes: tuple[Plane, Plane, Plane],
    rim: int,
    axes: tuple[Plane, Plane],
    model: tuple[float, float, float, float],
    c: int,
    totals: Plane,
) -> None:
    """Add the moments of sixteen columns from c on, lane by lane."""
    patch, template, goal = planes
    columns, ys = axes
    half, own, loss, bias = (
        f32x16(model[0]),
        f32x16(model[1]),
        f32x16(-model[2]),
        f32x16(model[3]),
    )
    inside = load(columns, MASK, c)
    a0 = a1 = a2 = b0 = b1 = b2 = b3 = c0 = c1 = c2 = c3 = c4 = f32x16(0.0)
    d0 = d1 = e0 = e1 = e2 = f32x16(0.0)
    for r in range(ys.shape[0]):
        sides = load(patch, r + 1, c + 2) - load(patch, r + 1, c)
        ends = load(patch, r + 2, c + 1) - load(patch, r, c + 1)
        along = load(template, r + 1, c + 2) - load(template, r + 1, c)
        down = load(template, r + 2, c + 1) - load(template, r, c + 1)
        gx = fma(half, sides, along * own) * inside
        gy = fma(half, ends, down * own) * inside
        error = fma(loss, load(patch, r + 1, c + 1), load(goal, r + rim, c + rim) - bias)
        y = f32x16(ys[r])
        gx1, gy1 = gx * y, gy * y
        gy2 = gy1 * y
        a0, a1, a2 = fma(gx, gx, a0), fma(gx, gx1, a1), fma(gx1, gx1, a2)
        b0, b1, b2, b3 = (
            fma(gx, gy, b0),
            fma(gx, gy1, b1),
            fma(gx1, gy1, b2),
            fma(gx1, gy2, b3),
        )
        c0, c1, c2 = fma(gy, gy, c0), fma(gy, gy1, c1), fma(gy1, gy1, c2)
        c3, c4 = fma(gy1, gy2, c3), fma(gy2, gy2, c4)
        d0, d1 = fma(gx, error, d0), fma(gx1, error, d1)
        e0, e1, e2 = fma(gy, error, e0), fma(gy1, error, e1), fma(gy2, error, e2)
    sums = (a0, a1, a2, b0, b1, b2, b3, c0, c1, c2, c3, c4, d0, d1, e0, e1, e2)
    _add_moments(sums, load(columns, XS, c), totals)


@uncounted
def normal_equations(
    planes: tuple[Plane, Plane, Plane],
    rim: int,
    axes: tuple[Plane, Plane],
    inner: int,
    model: tuple[float, float, float, float],
    a: Matrix,
    g: NDArray[np.float64],
) -> None:
    """Write a (8, 8), symmetric, and g (8,) of the least-squares step a d = g.

    Parameters
    ----------
    planes : tuple
        Patch and template, with their rims, and what the patch is to become.
    rim
        Of the last of them: 1, or 0 if it starts at the first inner pixel.
    axes : tuple
        Columns (3, width) and normalised rows.
    inner
        How many columns are inside.
    model : tuple
        Factors of the patch's and of the template's differences of neighbours; gain and bias from
        the patch to the template's grey values.
    """
    totals = on_stack(np.float32, _MOMENTS, WIDTH)
    sums, moments = on_stack(np.float32, 1, WIDTH), on_stack(np.float64, _MOMENTS)
    totals[:] = 0.0
    for c in range(0, inner, WIDTH):
        _add_strip(planes, rim, axes, model, c, totals)
    for k in range(_MOMENTS // WIDTH):
        store(sums, 0, 0, horizontal_sums(totals, k * WIDTH))
        for t in range(WIDTH):
            moments[k * WIDTH + t] = sums[0, t]
    _write_matrix(moments, a)
    _write_right_side(moments, g)
