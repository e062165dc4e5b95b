"""Aligns a template with an image on one pyramid level: Gauss-Newton on the warp.

The update is H <- H N E N^-1, where N maps normalised coordinates to template pixels and E is
exp(sum d_i A_i) for compositional methods, or the equivalent of adding d to the parameters of the
warp for the additive one (warps.py). With the mean of both gradients as Jacobian this is
ESM (Benhimane & Malis 2007); the template's gradient alone gives the inverse, the image's the
forward method (Baker & Matthews 2004), because for a group the inverse of exp(d) is exp(-d).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.numerics.stack import on_stack
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.trackers.template.level_buffers import (
    COLUMN,
    COLUMNS,
    ERRORS,
    MEAN,
    PATCH,
    QUANTISED,
    RAW,
    ROW,
    SCALE,
    SIGMA,
    TEMPLATE,
    UNIT,
    PyramidLevel,
)
from seamark.sim.trackers.template.mutual_information import (
    FINE_BINS,
    REACH,
    bins_per_grey,
    information_gradient,
    information_hessian,
    quantise,
)
from seamark.sim.trackers.template.normal_equations import normal_equations
from seamark.sim.trackers.template.patches import (
    XS,
    Image,
    Matrix,
    blur,
    correlation,
    moments,
    warp_patch,
)
from seamark.sim.trackers.template.warps import (
    additive,
    apply,
    assign,
    exponential,
    multiply,
    reduce,
    solve,
)

_DAMPING = 1e-5  # of the diagonal: bounds parameters that the template hardly determines
_MIN_SIGMA = 0.25  # [grey] a flatter patch contains only rounding
_MAX_STEP_PX = 1e4
_LEAST_DEPTH = 0.01  # of the fourth coordinate, which is 1 at the template's first pixel
_ROUNDING_PX = 0.05  # patches are sampled in float32: of some thousand pixels, off by 0.001
# ZNCC converges quadratically. Mutual information (with the Hessian of a perfect match) and SSD
# (where water changes the grey values) converge linearly, so these two stop later.
_STOP_FACTOR = 0.2

SSD, ZNCC, MI = range(3)
INVALID, SANE, MISSED = range(3)  # what an alignment ends with


class Stage(NamedTuple):
    """Settings of the alignment on one pyramid level."""

    basis: Matrix  # (8, n) of the warp
    criterion: int  # SSD, ZNCC, MI
    weight: float  # of the image's own gradient: 0.5 ESM, 0 inverse, 1 forward
    is_additive: bool  # whether parameters are added instead of warps composed
    iterations: int  # at most
    stop_px: float  # stop when no corner moves farther
    smooth: bool  # whether the patch is smoothed; if not, the image already is


@uncounted
def is_known(h: Matrix, level: PyramidLevel, known: NDArray[np.float64]) -> bool:
    """Return whether the patch under the homography lies within bounds, (4,) as of `known_bounds`.

    Where all its corners lie before the camera, so does all between them. Without bounds anything
    is known.
    """
    if known[0] == known[1] == -np.inf and known[2] == known[3] == np.inf:
        return True
    columns, rows = level.frame[COLUMNS], float(level.ys.shape[0])
    low_u, low_v = known[0] + _ROUNDING_PX, known[1] + _ROUNDING_PX
    high_u, high_v = known[2] - 1.0 - _ROUNDING_PX, known[3] - 1.0 - _ROUNDING_PX
    for k in range(4):
        x, y = columns if k % 2 else -1.0, rows if k > 1 else -1.0
        z = h[2, 0] * x + h[2, 1] * y + h[2, 2]
        if not z > _LEAST_DEPTH:
            return False
        u = (h[0, 0] * x + h[0, 1] * y + h[0, 2]) / z
        v = (h[1, 0] * x + h[1, 1] * y + h[1, 2]) / z
        if not (low_u <= u <= high_u and low_v <= v <= high_v):
            return False
    return True


@uncounted
def extract_patch(
    image: Image, bounds: NDArray[np.float64], h: Matrix, level: PyramidLevel, smooth: bool
) -> None:
    """Sample the image under the homography into the level's patch, and smooth it if asked to."""
    bench, unit, width = level.bench, level.frame[UNIT], int(level.frame[COLUMNS]) + 2
    columns = (level.columns, width)
    if not smooth:
        warp_patch(image, bounds, h, unit, columns, bench[PATCH])
        return
    warp_patch(image, bounds, h, unit, columns, bench[RAW])
    blur(bench[RAW], width, bench[PATCH])


@uncounted
def zncc(level: PyramidLevel) -> float:
    """Return the ZNCC of the template with the level's patch."""
    own = (level.frame[MEAN], level.frame[SIGMA])
    inner = int(level.frame[COLUMNS])
    return correlation(level.bench[PATCH], level.planes[TEMPLATE], level.columns, inner, own)


@uncounted
def _equations(
    level: PyramidLevel, weight: float, criterion: int, a: Matrix, g: NDArray[np.float64]
) -> None:
    """Write the normal equations of the next step for a criterion."""
    planes, frame = level.planes, level.frame
    patch, template, gain, bias = level.bench[PATCH], planes[TEMPLATE], 1.0, 0.0
    goal = template
    half, rim, inner = 0.5 * weight, 1, int(frame[COLUMNS])
    if criterion != SSD:
        m, s = moments(patch, level.columns, inner)
        gain = frame[SIGMA] / max(s, _MIN_SIGMA)
        bias = frame[MEAN] - gain * m
        half *= gain
    if criterion == MI:
        scale = bins_per_grey(frame[SIGMA])
        errors = level.bench[ERRORS, : level.ys.shape[0]]
        fine = _fine_values(frame)
        quantise(patch, 1, (fine[0] * gain, fine[0] * bias + fine[1]), errors)
        own = planes[QUANTISED, : level.ys.shape[0]]
        information_gradient(own, errors, inner, weight, scale, errors)
        goal, rim, gain, bias = errors, 0, 0.0, 0.0
    model = (half, 0.5 * (1.0 - weight), gain, bias)
    axes = (level.columns, level.ys)
    normal_equations((patch, template, goal), rim, axes, inner, model, a, g)
    if criterion == MI:
        assign(level.hessian, a)


@uncounted
def _fine_values(frame: NDArray[np.float64]) -> tuple[float, float]:
    """Return gain and offset from the template's grey values to fine bins."""
    factor = (FINE_BINS - 1.0) / (2.0 * REACH * frame[SIGMA])
    return factor, 0.5 * (FINE_BINS - 1.0) - factor * frame[MEAN]


@uncounted
def _step(a: Matrix, g: NDArray[np.float64], basis: Matrix, d: NDArray[np.float64]) -> bool:
    """Write the step d (8,) that solves the normal equations within the warp's basis."""
    n = basis.shape[1]
    reduced = on_stack(np.float64, 8, 8)[:n, :n]
    right = on_stack(np.float64, 8)[:n]
    if n == 8:  # all homographies: the basis is the identity
        assign(a, reduced)
        for q in range(8):
            right[q] = g[q]
    else:
        reduce(a, g, basis, reduced, right)
    for i in range(n):
        reduced[i, i] *= 1.0 + _DAMPING
    if not solve(reduced, right):
        return False
    for q in range(8):
        d[q] = 0.0
        for i in range(n):
            d[q] += basis[q, i] * right[i]
    return True


@uncounted
def _update(
    h: Matrix,
    d: NDArray[np.float64],
    frame: NDArray[np.float64],
    stage: Stage,
) -> None:
    """Replace h by h N E(d) N^-1, scaled to h[2, 2] = 1."""
    scale, column, row = frame[SCALE], frame[COLUMN], frame[ROW]
    t, e, u = (on_stack(np.float64, 3, 3), on_stack(np.float64, 3, 3), on_stack(np.float64, 3, 3))
    for i in range(3):
        t[i, 0] = h[i, 0] * scale
        t[i, 1] = h[i, 1] * scale
        t[i, 2] = h[i, 0] * column + h[i, 1] * row + h[i, 2]
    if stage.is_additive:
        additive(d, stage.basis.shape[1], t, e)
    else:
        exponential(d, e)
    multiply(t, e, u)
    last = u[2, 2] - (u[2, 0] * column + u[2, 1] * row) / scale
    for i in range(3):
        h[i, 0] = u[i, 0] / (scale * last)
        h[i, 1] = u[i, 1] / (scale * last)
        h[i, 2] = (u[i, 2] - (u[i, 0] * column + u[i, 1] * row) / scale) / last


@uncounted
def _template_corners(level: PyramidLevel, out: Matrix) -> None:
    """Write the template's outermost pixel centres (4, 2) in reading order."""
    out[:] = 0.0
    out[1, 0] = out[2, 0] = level.frame[COLUMNS] - 1.0
    out[2, 1] = out[3, 1] = level.ys.shape[0] - 1.0


@uncounted
def _largest_step(before: Matrix, after: Matrix) -> float:
    """Return the largest motion |du| + |dv| of the corners; inf if one is not finite."""
    largest = 0.0
    for k in range(4):
        moved = abs(after[k, 0] - before[k, 0]) + abs(after[k, 1] - before[k, 1])
        if not moved < _MAX_STEP_PX:
            return np.inf
        largest = max(largest, moved)
    return largest


@uncounted
def align(
    image: Image,
    bounds: NDArray[np.float64],
    known: NDArray[np.float64],
    h: Matrix,
    level: PyramidLevel,
    stage: Stage,
) -> tuple[int, int]:
    """Improve h (template px -> image px) in place; return iterations, and `SANE` if h is valid.

    It is `MISSED` if more of the image is needed than is known.
    """
    a = on_stack(np.float64, 8, 8)
    g = on_stack(np.float64, 8)
    d = on_stack(np.float64, 8)
    rim = on_stack(np.float64, 4, 2)
    before = on_stack(np.float64, 4, 2)
    after = on_stack(np.float64, 4, 2)
    stop_px = stage.stop_px * (1.0 if stage.criterion == ZNCC else _STOP_FACTOR)
    _template_corners(level, rim)
    apply(h, rim, before)
    for done in range(1, stage.iterations + 1):
        if not is_known(h, level, known):
            return done, MISSED
        extract_patch(image, bounds, h, level, stage.smooth)
        _equations(level, stage.weight, stage.criterion, a, g)
        if not _step(a, g, stage.basis, d):
            return done, INVALID
        for q in range(8):
            d[q] = min(max(d[q] / level.frame[SCALE], -1.0), 1.0)
        _update(h, d, level.frame, stage)
        apply(h, rim, after)
        largest = _largest_step(before, after)
        if largest == np.inf:
            return done, INVALID
        assign(after, before)
        if largest < stop_px:
            return done, SANE
    return stage.iterations, SANE


def set_template(level: PyramidLevel, criterion: int) -> None:
    """Make the level's patch the template."""
    columns = int(level.frame[COLUMNS])
    patch = level.bench[PATCH]
    mean, sigma = moments(patch, level.columns, columns)
    level.frame[MEAN], level.frame[SIGMA] = mean, max(sigma, _MIN_SIGMA)
    level.planes[TEMPLATE, :, : columns + 2] = patch[:, : columns + 2]
    if criterion == MI:
        half = np.float32(0.5)
        along = (patch[1:-1, 2 : columns + 2] - patch[1:-1, :columns]) * half
        down = (patch[2:, 1 : columns + 1] - patch[:-2, 1 : columns + 1]) * half
        _set_information_hessian(level, np.stack([along, down]).astype(np.float64))


def _set_information_hessian(level: PyramidLevel, gradients: NDArray[np.float64]) -> None:
    columns = gradients.shape[2]
    own = level.planes[QUANTISED, : len(level.ys)]
    factor, offset = _fine_values(level.frame)
    quantise(level.bench[PATCH], 1, (factor, offset), own)
    x, y = level.columns[XS, :columns].astype(np.float64), level.ys.astype(np.float64)[:, None]
    gx, gy = gradients
    t = gx * x + gy * y
    jacobian = np.stack([gx * x, gx * y, gy * x, gy * y, -x * t, -y * t, gx, gy], axis=-1)
    scale = bins_per_grey(level.frame[SIGMA])
    information_hessian(own, columns, scale, np.ascontiguousarray(jacobian), level.hessian)
