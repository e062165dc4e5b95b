"""Mutual information of template and patch: its gradient by pixel, and its Hessian.

Dame & Marchand (ISMAR 2010): a joint histogram with quadratic B-splines as bins, computed in two
steps, which is exact and fast. Pixels are counted as pairs of 64 fine bins, in integers; then the
counts, not the pixels, are distributed over ten coarse bins. The contribution of a pixel to the
gradient depends only on its pair and comes from a table. The bins cover 2.5 standard deviations on
both sides of the mean, after the patch was scaled to the template's mean and deviation.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.libm import log
from seamark.sim.numerics.simd import WIDTH, f32x16, load, maximum, minimum, store
from seamark.sim.numerics.stack import on_stack
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.trackers.template.patches import Matrix, Plane

BINS = 10
FINE_BINS = 64
REACH = 2.5  # [deviations] on both sides of the mean
_STEP = (BINS - 3.0) / (FINE_BINS - 1.0)  # [bins] between two fine bins
_LOG_OF_EMPTY = -6.0  # used for the logarithm of an empty bin


def _splines() -> tuple[Matrix, Matrix, Matrix]:
    """Return weights, first and second derivatives [per bin] of all fine bins in all bins.

    The derivatives at the ends are zero, since values are clipped there.
    """
    weights, slopes, bends = (np.zeros((FINE_BINS, BINS)) for _ in range(3))
    for code in range(FINE_BINS):
        k = int(code * _STEP + 0.5)
        d = code * _STEP - k
        weights[code, k : k + 3] = 0.5 * (0.5 - d) ** 2, 0.75 - d * d, 0.5 * (0.5 + d) ** 2
        if 0 < code < FINE_BINS - 1:
            slopes[code, k : k + 3] = d - 0.5, -2.0 * d, d + 0.5
            bends[code, k : k + 3] = 1.0, -2.0, 1.0
    return weights, slopes, bends


_WEIGHTS, _SLOPES, _BENDS = _splines()
_FIRST = np.array(
    [int(code * _STEP + 0.5) for code in range(FINE_BINS)]
)  # first coarse bin of each fine bin


@uncounted
def bins_per_grey(sigma: float) -> float:
    """Return bins per grey value, for a template with this standard deviation [grey]."""
    return (BINS - 3.0) / (2.0 * REACH * sigma)


@uncounted
def quantise(values: Plane, rim: int, model: tuple[float, float], out: Plane) -> None:
    """Write the nearest fine bins 0..63 of gain * values + bias, without `rim`."""
    gain, bias = f32x16(model[0]), f32x16(model[1] + 0.5)
    least, most = f32x16(0.0), f32x16(FINE_BINS - 0.5)
    for r in range(out.shape[0]):
        for c in range(0, out.shape[1] - WIDTH, WIDTH):
            value = gain * load(values, r + rim, c + rim) + bias
            store(out, r, c, minimum(maximum(value, least), most))


@uncounted
def _joint_histogram(template: Plane, patch: Plane, columns: int, pairs: NDArray[np.int32]) -> None:
    """Write the counts of pairs (template, patch) of fine bins."""
    pairs[:] = 0
    for r in range(template.shape[0]):
        for c in range(columns):
            t, i = np.int32(template[r, c]), np.int32(patch[r, c])
            pairs[np.uint64(t), np.uint64(i)] += np.int32(1)


@uncounted
def _joint_probabilities(pairs: NDArray[np.int32], count: int, p: Matrix) -> None:
    """Write the joint probabilities p[template bin, patch bin] (10, 10)."""
    spread = on_stack(np.float64, BINS, FINE_BINS)
    spread[:] = 0.0
    for code in range(FINE_BINS):
        for k in range(_FIRST[code], _FIRST[code] + 3):
            weight = _WEIGHTS[code, k] / count
            for i in range(FINE_BINS):
                spread[k, i] += weight * pairs[code, i]
    p[:] = 0.0
    for t in range(BINS):
        for i in range(FINE_BINS):
            for k in range(_FIRST[i], _FIRST[i] + 3):
                p[t, k] += spread[t, i] * _WEIGHTS[i, k]


@uncounted
def _log_ratios(p: Matrix, over_patch: Matrix, over_template: Matrix) -> None:
    """Write log(p / p of the patch's bin) and log(p / p of the template's bin)."""
    of_template, of_patch = on_stack(np.float64, BINS), on_stack(np.float64, BINS)
    of_template[:] = 0.0
    of_patch[:] = 0.0
    for t in range(BINS):
        for k in range(BINS):
            of_template[t] += p[t, k]
            of_patch[k] += p[t, k]
    for t in range(BINS):
        for k in range(BINS):
            over_patch[t, k] = over_template[t, k] = _LOG_OF_EMPTY
            if p[t, k] > 1e-9:
                own = log(p[t, k])
                over_patch[t, k] = own - log(of_patch[k])
                over_template[t, k] = own - log(of_template[t])


@uncounted
def _table(
    template_side: Matrix, logs: Matrix, patch_side: Matrix, factor: float, out: Plane
) -> None:
    """Add factor * template_side @ logs @ patch_side.T, for all pairs of fine bins."""
    half = on_stack(np.float32, BINS, FINE_BINS)
    half[:] = 0.0
    for t in range(BINS):
        for i in range(FINE_BINS):
            for k in range(_FIRST[i], _FIRST[i] + 3):
                half[t, i] += np.float32(logs[t, k] * patch_side[i, k])
    for code in range(FINE_BINS):
        row = out[code]
        for t in range(_FIRST[code], _FIRST[code] + 3):
            weight = np.float32(factor * template_side[code, t])
            part = half[t]
            for i in range(FINE_BINS):
                row[i] += weight * part[i]


@uncounted
def information_gradient(
    template: Plane, patch: Plane, columns: int, weight: float, scale: float, errors: Plane
) -> None:
    """Write the gradient of the information by the patch's grey values, in place of an error.

    Parameters
    ----------
    template, patch : (rows, width)
        Fine bins. `errors` may be `patch`.
    weight : float
        Weight of the derivative by the patch's values; the rest is that by the template's, negated:
        1 forward, 0 inverse, 0.5 ESM.
    scale : float
        Bins per grey value.
    """
    count = template.shape[0] * columns
    pairs, table = (
        on_stack(np.int32, FINE_BINS, FINE_BINS),
        on_stack(np.float32, FINE_BINS, FINE_BINS),
    )
    p, over_patch, over_template = (
        on_stack(np.float64, BINS, BINS),
        on_stack(np.float64, BINS, BINS),
        on_stack(np.float64, BINS, BINS),
    )
    table[:] = 0.0
    _joint_histogram(template, patch, columns, pairs)
    _joint_probabilities(pairs, count, p)
    _log_ratios(p, over_patch, over_template)
    _table(_WEIGHTS, over_patch, _SLOPES, weight * scale, table)
    _table(_SLOPES, over_template, _WEIGHTS, (weight - 1.0) * scale, table)
    for r in range(template.shape[0]):
        for c in range(columns):
            t, i = np.int32(template[r, c]), np.int32(patch[r, c])
            errors[r, c] = table[np.uint64(t), np.uint64(i)]


@njit(cache=True, nogil=True, error_model="numpy")
def information_hessian(
    template: Plane, columns: int, scale: float, jacobian: NDArray[np.float64], out: Matrix
) -> None:
    """Write the negative Hessian (8, 8) of count times the information at a perfect match.

    Parameters
    ----------
    template : (rows, width)
        Fine bins.
    jacobian : (rows, columns, 8)
        Of the template.
    """
    count = template.shape[0] * columns
    pairs = np.empty((FINE_BINS, FINE_BINS), np.int32)
    p, over_patch, over_template = (
        np.empty((BINS, BINS)),
        np.empty((BINS, BINS)),
        np.empty((BINS, BINS)),
    )
    by_value = np.zeros((FINE_BINS, 8))
    slopes = np.zeros((BINS, BINS, 8))
    _joint_histogram(template, template, columns, pairs)
    _joint_probabilities(pairs, count, p)
    _log_ratios(p, over_patch, over_template)
    out[:] = 0.0
    _subtract_second_derivatives(template, over_template, jacobian, by_value, out)
    for value in range(FINE_BINS):
        for t in range(_FIRST[value], _FIRST[value] + 3):
            for k in range(_FIRST[value], _FIRST[value] + 3):
                weight = _SLOPES[value, t] * _WEIGHTS[value, k] / count
                slopes[t, k] += weight * by_value[value]
    _subtract_squared_slopes(slopes, p, count, out)
    out *= scale * scale


@njit(cache=True, nogil=True, error_model="numpy")
def _add_square(vector: NDArray[np.float64], factor: float, out: Matrix) -> None:
    """Add the factor times the outer product of a vector (8,) with itself."""
    for i in range(8):
        for j in range(8):
            out[i, j] += factor * vector[i] * vector[j]


@njit(cache=True, nogil=True, error_model="numpy")
def _subtract_second_derivatives(
    template: Plane,
    logs: Matrix,
    jacobian: NDArray[np.float64],
    by_value: Matrix,
    out: Matrix,
) -> None:
    """Subtract the term of second derivatives of the bins; sum the Jacobian by fine bin."""
    bend = np.zeros(FINE_BINS)
    for value in range(FINE_BINS):
        for t in range(_FIRST[value], _FIRST[value] + 3):
            for k in range(_FIRST[value], _FIRST[value] + 3):
                bend[value] += _BENDS[value, t] * _WEIGHTS[value, k] * logs[t, k]
    for r in range(jacobian.shape[0]):
        for c in range(jacobian.shape[1]):
            value = int(template[r, c])
            by_value[value] += jacobian[r, c]
            _add_square(jacobian[r, c], -bend[value], out)


@njit(cache=True, nogil=True, error_model="numpy")
def _subtract_squared_slopes(
    slopes: NDArray[np.float64], p: Matrix, count: int, out: Matrix
) -> None:
    """Subtract the terms of squared slopes: those of p, less those of the template's bins."""
    for t in range(BINS):
        margin, slope = 0.0, np.zeros(8)
        for k in range(BINS):
            margin += p[t, k]
            slope += slopes[t, k]
            if p[t, k] > 1e-9:
                _add_square(slopes[t, k], -count / p[t, k], out)
        if margin > 1e-9:
            _add_square(slope, count / margin, out)
