"""Normal equations of one step: sums over all pixels of products of gradients and errors.

Columns of the Jacobian are gx x, gx y, gy x, gy y, -x t, -y t, gx, gy with t = gx x + gy y, so all
sums are of gx gx, gx gy, gy gy, gx e or gy e times powers of x and y. The loops go down sixteen
columns at once: only powers of y are summed there; x is constant and multiplied in afterwards.
Each loop has only as many sums as fit into sixteen registers of eight lanes; one loop with all
seventeen took 1.6 times as long on a processor with such registers.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.simd import WIDTH, f32x16, fma, horizontal_sum, load, store
from seamark.sim.numerics.stack import on_stack
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.trackers.template.patches import MASK, XS, Matrix, Plane

# Each column as terms: direction of the gradient (0 x, 1 y), power of x, power of y, sign.
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
# Index of the first of the sums over gx gx y^k, gx gy y^k, gy gy y^k, gx e y^k, gy e y^k.
_SQUARES = (0, 3, 7)
_ERRORS = (12, 14)
_SUMS = 17


def _tables() -> tuple[NDArray[np.int64], NDArray[np.int64], Matrix]:
    """Return the moments, and the terms of the equations that they make up.

    A moment is (sum, power of x); a term (row, column, moment), with its sign. Column 8 is g.
    """
    moments: dict[tuple[int, int], int] = {}
    terms, signs = [], []

    def add(row: int, column: int, moment: tuple[int, int], sign: float) -> None:
        terms.append((row, column, moments.setdefault(moment, len(moments))))
        signs.append(sign)

    for i, left in enumerate(_JACOBIAN):
        for d1, x1, y1, s1 in left:
            add(i, 8, (_ERRORS[d1] + y1, x1), s1)
            for j, right in enumerate(_JACOBIAN):
                for d2, x2, y2, s2 in right:
                    add(i, j, (_SQUARES[d1 + d2] + y1 + y2, x1 + x2), s1 * s2)
    return np.array(list(moments)), np.array(terms), np.array(signs)


_MOMENTS, _TERMS, _SIGNS = _tables()
_COUNT = len(_MOMENTS)


@uncounted
def _strip(
    planes: tuple[Plane, Plane, Plane, Plane],
    model: tuple[float, float, float],
    mask: Plane,
    c: int,
    out: Plane,
) -> None:
    """Write both gradients and the error of sixteen columns from c on, row after row."""
    patch, template, along, down = planes
    half, loss, bias = f32x16(model[0]), f32x16(-model[1]), f32x16(model[2])
    inside = load(mask, MASK, c)
    for r in range(patch.shape[0] - 2):
        sides = load(patch, r + 1, c + 2) - load(patch, r + 1, c)
        ends = load(patch, r + 2, c + 1) - load(patch, r, c + 1)
        store(out, 3 * r, 0, fma(half, sides, load(along, r, c)) * inside)
        store(out, 3 * r + 1, 0, fma(half, ends, load(down, r, c)) * inside)
        error = fma(loss, load(patch, r + 1, c + 1), load(template, r, c) - bias)
        store(out, 3 * r + 2, 0, error)


@uncounted
def _sums_along(strip: Plane, ys: Plane, out: Plane) -> None:
    """Write the sums over gx gx y^k and gx e y^k of a strip, lane by lane."""
    a0 = a1 = a2 = d0 = d1 = f32x16(0.0)
    for r in range(ys.shape[0]):
        gx, error = load(strip, 3 * r, 0), load(strip, 3 * r + 2, 0)
        gx1 = gx * f32x16(ys[r])
        a0 = fma(gx, gx, a0)
        a1 = fma(gx, gx1, a1)
        a2 = fma(gx1, gx1, a2)
        d0 = fma(gx, error, d0)
        d1 = fma(gx1, error, d1)
    store(out, 0, 0, a0)
    store(out, 1, 0, a1)
    store(out, 2, 0, a2)
    store(out, 12, 0, d0)
    store(out, 13, 0, d1)


@uncounted
def _sums_across(strip: Plane, ys: Plane, out: Plane) -> None:
    """Write the sums over gx gy y^k."""
    b0 = b1 = b2 = b3 = f32x16(0.0)
    for r in range(ys.shape[0]):
        gx, gy, y = load(strip, 3 * r, 0), load(strip, 3 * r + 1, 0), f32x16(ys[r])
        gx1, gy1 = gx * y, gy * y
        b0 = fma(gx, gy, b0)
        b1 = fma(gx, gy1, b1)
        b2 = fma(gx1, gy1, b2)
        b3 = fma(gx1, gy1 * y, b3)
    store(out, 3, 0, b0)
    store(out, 4, 0, b1)
    store(out, 5, 0, b2)
    store(out, 6, 0, b3)


@uncounted
def _sums_down(strip: Plane, ys: Plane, out: Plane) -> None:
    """Write the sums over gy gy y^k and gy e y^k."""
    c0 = c1 = c2 = c3 = c4 = f32x16(0.0)
    for r in range(ys.shape[0]):
        gy, y = load(strip, 3 * r + 1, 0), f32x16(ys[r])
        gy1 = gy * y
        gy2 = gy1 * y
        c0 = fma(gy, gy, c0)
        c1 = fma(gy, gy1, c1)
        c2 = fma(gy1, gy1, c2)
        c3 = fma(gy1, gy2, c3)
        c4 = fma(gy2, gy2, c4)
    e0 = e1 = e2 = f32x16(0.0)
    for r in range(ys.shape[0]):
        gy, error, y = load(strip, 3 * r + 1, 0), load(strip, 3 * r + 2, 0), f32x16(ys[r])
        gy1 = gy * y
        e0 = fma(gy, error, e0)
        e1 = fma(gy1, error, e1)
        e2 = fma(gy1 * y, error, e2)
    store(out, 7, 0, c0)
    store(out, 8, 0, c1)
    store(out, 9, 0, c2)
    store(out, 10, 0, c3)
    store(out, 11, 0, c4)
    store(out, 14, 0, e0)
    store(out, 15, 0, e1)
    store(out, 16, 0, e2)


@njit(cache=True, nogil=True, error_model="numpy")
def normal_equations(
    planes: tuple[Plane, Plane, Plane, Plane],
    axes: tuple[Plane, Plane],
    model: tuple[float, float, float],
    a: Matrix,
    g: NDArray[np.float64],
) -> None:
    """Write a (8, 8), symmetric, and g (8,) of the least-squares step a d = g.

    Parameters
    ----------
    planes : tuple
        The patch, with its rim; the template; its gradients along the rows and down the columns,
        already weighted.
    axes : tuple
        Columns (3, width) and normalised rows.
    model : tuple
        Factor of the patch's differences of neighbours; gain and bias from the patch to the
        template's grey values.
    """
    columns, ys = axes
    strip = np.empty((3 * ys.shape[0], WIDTH), np.float32)
    sums, powers = on_stack(np.float32, _SUMS, WIDTH), on_stack(np.float32, 5, WIDTH)
    totals, moments = on_stack(np.float32, _COUNT, WIDTH), on_stack(np.float64, _COUNT)
    totals[:] = 0.0
    for c in range(0, columns.shape[1] - WIDTH, WIDTH):
        _strip(planes, model, columns, c, strip)
        _sums_along(strip, ys, sums)
        _sums_across(strip, ys, sums)
        _sums_down(strip, ys, sums)
        x = load(columns, XS, c)
        power = f32x16(1.0)
        for k in range(5):
            store(powers, k, 0, power)
            power = power * x
        for t in range(_MOMENTS.shape[0]):
            part = load(sums, _MOMENTS[t, 0], 0) * load(powers, _MOMENTS[t, 1], 0)
            store(totals, t, 0, load(totals, t, 0) + part)
    for t in range(totals.shape[0]):
        moments[t] = horizontal_sum(load(totals, t, 0))
    a[:] = 0.0
    g[:] = 0.0
    for t in range(_SIGNS.shape[0]):
        i, j = _TERMS[t, 0], _TERMS[t, 1]
        if j == 8:
            g[i] += _SIGNS[t] * moments[_TERMS[t, 2]]
        else:
            a[i, j] += _SIGNS[t] * moments[_TERMS[t, 2]]
