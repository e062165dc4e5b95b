"""Aligns a template with an image: Gauss-Newton on the warp, coarse level first.

The update is H <- H N exp(sum d_i A_i) N^-1 where N maps normalised coordinates to template pixels.
With the mean of both gradients as Jacobian this is ESM (Benhimane & Malis 2007); the template's
gradient alone gives the inverse compositional, the image's the forward compositional method (Baker
& Matthews 2004), because for a group the inverse of exp(d) is exp(-d).
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.trackers.interface import Window
from sim.trackers.patches import (
    TEMPLATE_SIGMA,
    Matrix,
    Plane,
    blur,
    halve,
    moments,
    normal_equations,
    warp_patch,
)
from sim.trackers.warps import apply, exponential, multiply, solve

_DAMPING = 1e-5  # of the diagonal: keeps a parameter that the template hardly shows from exploding
_LEAST_SIGMA = 0.25  # [grey] a flatter patch holds nothing but rounding


class Level(NamedTuple):
    """A template at one resolution, with the work arrays of its alignment."""

    template: Plane  # (rows, columns) grey values times `gain`
    gradients: Plane  # (2, rows, columns), weighted by the method
    xs: Plane  # normalised columns
    ys: Plane  # normalised rows
    frame: NDArray[np.float64]  # (6,): scale, centre column, centre row, mean, sigma, gain
    patch: Plane
    work: Plane
    places: NDArray[np.int32]
    fractions: Plane


class Search(NamedTuple):
    """How the alignment goes on."""

    coarse_basis: Matrix  # (8, n): at most scale, rotation, translation, which cannot shear away
    basis: Matrix  # (8, n) of the warp
    weight: float  # of the image's own gradient: 0.5 ESM, 0 inverse, 1 forward
    normalised: bool  # zncc: the patch is brought to the template's mean and deviation
    coarse_iterations: int
    fine_iterations: int
    stop_px: float  # a step that moves every corner less is the last


@njit(cache=True, nogil=True, error_model="numpy")
def cut(image: NDArray[np.uint8] | Plane, bounds: Plane, h: Matrix, level: Level) -> None:
    """Fill the level's patch with the smoothed image under the homography."""
    warp_patch(image, bounds, h, level.patch, level.places, level.fractions)
    blur(level.patch, level.work)


@njit(cache=True, nogil=True, error_model="numpy")
def _reduce(
    a: Matrix, g: NDArray[np.float64], basis: Matrix, reduced: Matrix, right: NDArray[np.float64]
) -> None:
    """Write the normal equations within the warp's basis, slightly damped."""
    n = basis.shape[1]
    for i in range(n):
        right[i] = 0.0
        for q in range(8):
            right[i] += basis[q, i] * g[q]
        for j in range(n):
            total = 0.0
            for q in range(8):
                row = 0.0
                for k in range(8):
                    row += a[q, k] * basis[k, j]
                total += basis[q, i] * row
            reduced[i, j] = total
        reduced[i, i] *= 1.0 + _DAMPING


@njit(cache=True, nogil=True, error_model="numpy")
def _step(a: Matrix, g: NDArray[np.float64], basis: Matrix, d: NDArray[np.float64]) -> bool:
    """Write the step d (8,) that solves the normal equations within the warp's basis."""
    n = basis.shape[1]
    reduced = np.empty((n, n))
    right = np.empty(n)
    _reduce(a, g, basis, reduced, right)
    if not solve(reduced, right):
        return False
    for q in range(8):
        d[q] = 0.0
        for i in range(n):
            d[q] += basis[q, i] * right[i]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _compose(h: Matrix, d: NDArray[np.float64], frame: NDArray[np.float64]) -> None:
    """Replace h by h N exp(d) N^-1, scaled to h[2, 2] = 1."""
    scale, column, row = frame[0], frame[1], frame[2]
    n = np.zeros((3, 3))
    n[0, 0] = scale
    n[0, 2] = column
    n[1, 1] = scale
    n[1, 2] = row
    n[2, 2] = 1.0
    e = np.empty((3, 3))
    t = np.empty((3, 3))
    u = np.empty((3, 3))
    exponential(d, e)
    multiply(h, n, t)
    multiply(t, e, u)
    n[0, 0] = 1.0 / scale
    n[0, 2] = -column / scale
    n[1, 1] = 1.0 / scale
    n[1, 2] = -row / scale
    multiply(u, n, t)
    for i in range(3):
        for j in range(3):
            h[i, j] = t[i, j] / t[2, 2]


@njit(cache=True, nogil=True, error_model="numpy")
def template_corners(level: Level, out: Matrix) -> None:
    """Write the template's outermost pixel centres (4, 2) in reading order."""
    rows, columns = level.template.shape
    out[:] = 0.0
    out[1, 0] = columns - 1.0
    out[2, 0] = columns - 1.0
    out[2, 1] = rows - 1.0
    out[3, 1] = rows - 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def align(
    image: NDArray[np.uint8] | Plane,
    bounds: Plane,
    h: Matrix,
    level: Level,
    search: Search,
    basis: Matrix,
    iterations: int,
) -> tuple[int, bool]:
    """Improve h (template px -> image px) in place; return iterations and whether it is sane."""
    a = np.empty((8, 8))
    g = np.empty(8)
    d = np.empty(8)
    rim = np.empty((4, 2))
    before = np.empty((4, 2))
    after = np.empty((4, 2))
    template_corners(level, rim)
    apply(h, rim, before)
    mean, sigma, own = level.frame[3], level.frame[4], level.frame[5]
    for done in range(1, iterations + 1):
        cut(image, bounds, h, level)
        gain = own
        bias = 0.0
        if search.normalised:
            m, s = moments(level.patch)
            gain = sigma / max(s, _LEAST_SIGMA)
            bias = mean - gain * m
        model = (search.weight, gain, bias)
        normal_equations(
            level.patch, level.template, level.gradients, (level.xs, level.ys), model, a, g
        )
        if not _step(a, g, basis, d):
            return done, False
        for q in range(8):
            d[q] = min(max(d[q] / level.frame[0], -1.0), 1.0)
        _compose(h, d, level.frame)
        apply(h, rim, after)
        largest = 0.0
        for k in range(4):
            moved = abs(after[k, 0] - before[k, 0]) + abs(after[k, 1] - before[k, 1])
            if not moved < 1e4:
                return done, False
            largest = max(largest, moved)
            before[k, 0] = after[k, 0]
            before[k, 1] = after[k, 1]
        if largest < search.stop_px:
            return done, True
    return iterations, True


@njit(cache=True, nogil=True, error_model="numpy")
def to_coarse(h: Matrix, x0: float, y0: float, out: Matrix) -> None:
    """Write h for a template and an image of half the resolution; the image starts at x0, y0."""
    t = np.empty((3, 3))
    for i in range(3):
        t[i, 0] = 2.0 * h[i, 0]
        t[i, 1] = 2.0 * h[i, 1]
        t[i, 2] = 0.5 * (h[i, 0] + h[i, 1]) + h[i, 2]
    for j in range(3):
        out[0, j] = 0.5 * (t[0, j] - (x0 + 0.5) * t[2, j])
        out[1, j] = 0.5 * (t[1, j] - (y0 + 0.5) * t[2, j])
        out[2, j] = t[2, j]


@njit(cache=True, nogil=True, error_model="numpy")
def from_coarse(h: Matrix, x0: float, y0: float, out: Matrix) -> None:
    """Undo `to_coarse`, scaled to out[2, 2] = 1."""
    t = np.empty((3, 3))
    for j in range(3):
        t[0, j] = 2.0 * h[0, j] + (x0 + 0.5) * h[2, j]
        t[1, j] = 2.0 * h[1, j] + (y0 + 0.5) * h[2, j]
        t[2, j] = h[2, j]
    for i in range(3):
        out[i, 2] = t[i, 2] - 0.25 * (t[i, 0] + t[i, 1])
        out[i, 0] = 0.5 * t[i, 0]
        out[i, 1] = 0.5 * t[i, 1]
    last = out[2, 2]
    for i in range(3):
        for j in range(3):
            out[i, j] /= last


@njit(cache=True, nogil=True, error_model="numpy")
def half_image(image: NDArray[np.uint8], window: Window) -> tuple[Plane, NDArray[np.float32]]:
    """Return the window at half the resolution and the bounds of that picture."""
    x0, y0, x1, y1 = window
    small = np.empty(((y1 - y0) // 2, (x1 - x0) // 2), np.float32)
    halve(image, x0, y0, small)
    bounds = np.zeros(4, np.float32)
    bounds[2] = small.shape[1]
    bounds[3] = small.shape[0]
    return small, bounds


@njit(cache=True, nogil=True, error_model="numpy")
def cut_start(
    image: NDArray[np.uint8],
    window: Window,
    h: Matrix,
    coarse: Level,
    fine: Level,
) -> None:
    """Fill both levels' patches from the picture in which the target is known."""
    bounds = np.empty(4, np.float32)
    for k in range(4):
        bounds[k] = window[k]
    small, small_bounds = half_image(image, window)
    low = np.empty((3, 3))
    to_coarse(h, window[0], window[1], low)
    cut(small, small_bounds, low, coarse)
    cut(image, bounds, h, fine)


def empty_level(columns: int, rows: int, *, scale: float, column: float, row: float) -> Level:
    """Return a level without a template yet.

    Parameters
    ----------
    scale, column, row : float [px]
        Half the longer side and the centre, in this level's pixels.
    """
    xs = ((np.arange(columns) - column) / scale).astype(np.float32)
    ys = ((np.arange(rows) - row) / scale).astype(np.float32)
    padded = (rows + 2, columns + 2)
    return Level(
        template=np.zeros((rows, columns), np.float32),
        gradients=np.zeros((2, rows, columns), np.float32),
        xs=xs,
        ys=ys,
        frame=np.array([scale, column, row, 0.0, 1.0, 1.0]),
        patch=np.zeros(padded, np.float32),
        work=np.zeros(padded, np.float32),
        places=np.zeros(columns + 2, np.int32),
        fractions=np.zeros((6, columns + 2), np.float32),
    )


def learn(level: Level, *, weight: float) -> None:
    """Take the level's patch as the template, scaled to TEMPLATE_SIGMA."""
    mean, sigma = moments(level.patch)
    gain = TEMPLATE_SIGMA / max(sigma, _LEAST_SIGMA)
    patch = level.patch * np.float32(gain)
    level.template[:] = patch[1:-1, 1:-1]
    half = np.float32(0.5 * (1.0 - weight))
    level.gradients[0] = (patch[1:-1, 2:] - patch[1:-1, :-2]) * half
    level.gradients[1] = (patch[2:, 1:-1] - patch[:-2, 1:-1]) * half
    level.frame[3:] = mean * gain, sigma * gain, gain
