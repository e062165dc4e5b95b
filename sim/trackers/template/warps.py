"""Motion models of a plane in the image: subgroups of the homographies, and their algebra.

A homography is written exp(sum d_i A_i) with eight generators in normalised template coordinates,
in the order a b c d p q tx ty: x' = a x + b y + tx - x w, y' = c x + d y + ty - y w, w = p x + q y,
to first order. Every warp is a basis (8, n) of some of them (Benhimane & Malis, IJRR 26(7), 2007).
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.libm import sincos
from seamark.sim.numerics.stack import on_stack
from seamark.sim.numerics.uncounted import uncounted

Matrix = NDArray[np.float64]


_UNIT = np.eye(8)
_SCALE, _TURN = _UNIT[0] + _UNIT[3], _UNIT[2] - _UNIT[1]
_GENERATORS = {
    "translation": [_UNIT[6], _UNIT[7]],
    "rt": [_TURN, _UNIT[6], _UNIT[7]],
    "srt": [_SCALE, _TURN, _UNIT[6], _UNIT[7]],
    "affine": [_UNIT[k] for k in (0, 1, 2, 3, 6, 7)],
    "homography": list(_UNIT),
}


def basis(warp: str) -> Matrix:
    """Return the basis (8, n) of a warp's parameters."""
    return np.ascontiguousarray(np.array(_GENERATORS[warp]).T)


@uncounted
def assign(source: Matrix, out: Matrix) -> None:
    """Copy a matrix; the assignment of slices compares their memory first, which takes longer."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            out[i, j] = source[i, j]


@uncounted
def multiply(a: Matrix, b: Matrix, out: Matrix) -> None:
    """Write the product of two 3x3 matrices; `out` is neither of them."""
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]


@uncounted
def inverse(a: Matrix, out: Matrix) -> None:
    """Write the inverse of a regular 3x3 matrix; `out` is another array."""
    for i in range(3):
        p = (i + 1) % 3
        q = (i + 2) % 3
        for k in range(3):
            k1 = (k + 1) % 3
            k2 = (k + 2) % 3
            out[i, k] = a[k1, p] * a[k2, q] - a[k2, p] * a[k1, q]
    determinant = out[0, 0] * a[0, 0] + out[0, 1] * a[1, 0] + out[0, 2] * a[2, 0]
    for i in range(3):
        for k in range(3):
            out[i, k] /= determinant


@uncounted
def _multiply_rows(a: Matrix, b: Matrix, out: Matrix) -> None:
    """Write what `multiply` does, of matrices with a fourth column, so that a row is a vector."""
    for i in range(3):
        for j in range(4):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]


@njit(cache=True, error_model="numpy", inline="always")
def _apply_term(x: Matrix, k: float, t: Matrix, out: Matrix) -> None:
    """Replace `out` by 1 + x out / k; with a constant k, many divisions are multiplications."""
    _multiply_rows(x, out, t)
    for i in range(3):
        for j in range(4):
            out[i, j] = t[i, j] / k + (1.0 if i == j else 0.0)


@uncounted
def exponential(d: Matrix, out: Matrix) -> None:
    """Write the homography exp(sum d_i A_i) (3, 3) of eight parameters (8,).

    Scaling by 1/16 and squaring with a Taylor polynomial of order 8: exact to 1e-13 for |d| <= 1.
    """
    x, t, e = on_stack(np.float64, 3, 4), on_stack(np.float64, 3, 4), on_stack(np.float64, 3, 4)
    x[0, 0] = d[0]
    x[0, 1] = d[1]
    x[0, 2] = d[6]
    x[1, 0] = d[2]
    x[1, 1] = d[3]
    x[1, 2] = d[7]
    x[2, 0] = d[4]
    x[2, 1] = d[5]
    x[2, 2] = 0.0
    for i in range(3):
        x[i, 3] = 0.0
        for j in range(4):
            x[i, j] *= 1.0 / 16.0
            e[i, j] = 1.0 if i == j else 0.0
    _apply_term(x, 8.0, t, e)
    _apply_term(x, 7.0, t, e)
    _apply_term(x, 6.0, t, e)
    _apply_term(x, 5.0, t, e)
    _apply_term(x, 4.0, t, e)
    _apply_term(x, 3.0, t, e)
    _apply_term(x, 2.0, t, e)
    _apply_term(x, 1.0, t, e)
    for _ in range(2):
        _multiply_rows(e, e, t)
        _multiply_rows(t, t, e)
    for i in range(3):
        for j in range(3):
            out[i, j] = e[i, j]


@uncounted
def additive(d: Matrix, parameters: int, at: Matrix, out: Matrix) -> None:
    """Write what h is to be multiplied by so that d is added to the parameters of the warp.

    That h E(d) has the parameters p + dp, with dp linear in d, is: for rotations that the angle
    grows by d's, for scales that the factor does; for affine warps that h's entries do; and for
    homographies so too, with h[2, 2] kept at 1. `at` (3, 3) is h in normalised coordinates and
    `parameters` the warp's number of them (2, 3, 4, 6 or 8).
    """
    if parameters < 6:
        s, c = sincos(d[2])
        factor = 1.0 + 0.5 * (d[0] + d[3])
        out[0, 0] = out[1, 1] = factor * c
        out[1, 0] = factor * s
        out[0, 1] = -out[1, 0]
        out[2, 0] = out[2, 1] = 0.0
    else:
        out[0, 0] = 1.0 + d[0]
        out[0, 1] = d[1]
        out[1, 0] = d[2]
        out[1, 1] = 1.0 + d[3]
        out[2, 0] = d[4]
        out[2, 1] = d[5]
    out[0, 2] = d[6]
    out[1, 2] = d[7]
    out[2, 2] = 1.0
    if parameters == 8:
        kept = (at[2, 0] * d[6] + at[2, 1] * d[7]) / at[2, 2]
        for i in range(3):
            out[i, i] -= kept


@uncounted
def apply(h: Matrix, points: Matrix, out: Matrix) -> None:
    """Write the images (n, 2) of points (n, 2) under a homography; NaN beyond the horizon."""
    for k in range(points.shape[0]):
        x = points[k, 0]
        y = points[k, 1]
        z = h[2, 0] * x + h[2, 1] * y + h[2, 2]
        if z > 1e-9:
            out[k, 0] = (h[0, 0] * x + h[0, 1] * y + h[0, 2]) / z
            out[k, 1] = (h[1, 0] * x + h[1, 1] * y + h[1, 2]) / z
        else:
            out[k, 0] = np.nan
            out[k, 1] = np.nan


@uncounted
def reduce(
    a: Matrix, g: NDArray[np.float64], basis: Matrix, reduced: Matrix, right: NDArray[np.float64]
) -> None:
    """Write the equations a d = g (8, 8) for a step within a basis (8, n): B' a B, B' g."""
    n = basis.shape[1]
    part = on_stack(np.float64, 8, 8)
    for q in range(8):
        for j in range(n):
            row = 0.0
            for k in range(8):
                row += a[q, k] * basis[k, j]
            part[q, j] = row
    for i in range(n):
        right[i] = 0.0
        for q in range(8):
            right[i] += basis[q, i] * g[q]
        for j in range(n):
            row = 0.0
            for q in range(8):
                row += basis[q, i] * part[q, j]
            reduced[i, j] = row


@uncounted
def _factorise(a: Matrix) -> bool:
    """Replace the lower triangle by the Cholesky factor; False if not positive definite.

    It goes down the columns, where no number waits for the division before.
    """
    n = a.shape[0]
    for j in range(n):
        for i in range(j, n):
            s = a[i, j]
            for k in range(j):
                s -= a[i, k] * a[j, k]
            if i != j:
                a[i, j] = s / a[j, j]
            elif s > 1e-9:
                a[i, i] = np.sqrt(s)
            else:
                return False
    return True


@uncounted
def solve(a: Matrix, b: NDArray[np.float64]) -> bool:
    """Solve a x = b for a positive definite a (n, n), by Cholesky in place; x replaces b.

    Returns False when a is not positive definite: the template does not determine the step.
    """
    if not _factorise(a):
        return False
    n = a.shape[0]
    for i in range(n):
        s = b[i]
        for k in range(i):
            s -= a[i, k] * b[k]
        b[i] = s / a[i, i]
    for i in range(n - 1, -1, -1):
        s = b[i]
        for k in range(i + 1, n):
            s -= a[k, i] * b[k]
        b[i] = s / a[i, i]
    return True


@uncounted
def from_square(quad: Matrix, out: Matrix) -> bool:
    """Write the homography from the unit square to a quadrilateral (4, 2), Heckbert 1989.

    The square's corners are (0, 0), (1, 0), (1, 1), (0, 1). False for a degenerate quadrilateral.
    """
    sx = quad[0, 0] - quad[1, 0] + quad[2, 0] - quad[3, 0]
    sy = quad[0, 1] - quad[1, 1] + quad[2, 1] - quad[3, 1]
    dx1 = quad[1, 0] - quad[2, 0]
    dx2 = quad[3, 0] - quad[2, 0]
    dy1 = quad[1, 1] - quad[2, 1]
    dy2 = quad[3, 1] - quad[2, 1]
    determinant = dx1 * dy2 - dx2 * dy1
    if not abs(determinant) > 1e-9:
        return False
    g = (sx * dy2 - dx2 * sy) / determinant
    h = (dx1 * sy - sx * dy1) / determinant
    out[0, 0] = quad[1, 0] - quad[0, 0] + g * quad[1, 0]
    out[0, 1] = quad[3, 0] - quad[0, 0] + h * quad[3, 0]
    out[0, 2] = quad[0, 0]
    out[1, 0] = quad[1, 1] - quad[0, 1] + g * quad[1, 1]
    out[1, 1] = quad[3, 1] - quad[0, 1] + h * quad[3, 1]
    out[1, 2] = quad[0, 1]
    out[2, 0] = g
    out[2, 1] = h
    out[2, 2] = 1.0
    return True


@uncounted
def signed_area(quad: Matrix) -> float:
    """Return the area [px^2] of a quadrilateral (4, 2), positive in the order of the corners."""
    total = 0.0
    for k in range(4):
        n = (k + 1) % 4
        total += quad[k, 0] * quad[n, 1] - quad[n, 0] * quad[k, 1]
    return 0.5 * total


@uncounted
def is_convex(quad: Matrix) -> bool:
    """Return whether a quadrilateral (4, 2) turns the same way, rightwards, at every corner."""
    for k in range(4):
        n = (k + 1) % 4
        m = (k + 2) % 4
        cross = (quad[n, 0] - quad[k, 0]) * (quad[m, 1] - quad[n, 1]) - (
            quad[n, 1] - quad[k, 1]
        ) * (quad[m, 0] - quad[n, 0])
        if not cross > 0.0:
            return False
    return True
