"""Thrust allocation: by the pseudo-inverse of the thruster matrix, or within thrusters' limits.

The pseudo-inverse is computed once, without BLAS, whose last bits depend on the processor.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.linear_algebra import inverse
from seamark.sim.vehicles import Vehicle

SURGE, SWAY, HEAVE, ROLL, PITCH, YAW = range(6)
_PRIORITY = (SURGE, SWAY, HEAVE, YAW, PITCH, ROLL)
_INDEPENDENT = 1e-6  # [1, m] least norm of a row orthogonal to the rows before it
SWEEPS = 400  # E: accelerations are then within 0.01 of the optimum, for all vehicles


def allocator(vehicle: Vehicle) -> NDArray[np.float64]:
    """Return the thrust of each thruster for a unit wrench, (n, 6) [N per N or N m].

    Axes that the thrusters cannot control independently get zeros; independent axes are chosen in
    the order surge, sway, heave, yaw, pitch, roll.
    """
    matrix = vehicle.allocation()
    axes = _controllable(matrix)
    rows = [list(map(float, matrix[axis])) for axis in axes]
    gram = np.array([[_dot(a, b) for b in rows] for a in rows])
    inner = inverse(gram)
    result = np.zeros((matrix.shape[1], 6))
    for thruster in range(matrix.shape[1]):
        column = [row[thruster] for row in rows]
        for at, axis in enumerate(axes):
            result[thruster, axis] = _dot(column, [float(x) for x in inner[:, at]])
    return result


def _controllable(matrix: NDArray[np.float64]) -> list[int]:
    """Return the axes with linearly independent rows (Gram-Schmidt)."""
    axes: list[int] = []
    basis: list[list[float]] = []
    for axis in _PRIORITY:
        rest = list(map(float, matrix[axis]))
        for known in basis:
            share = _dot(rest, known) / _dot(known, known)
            rest = [a - share * b for a, b in zip(rest, known, strict=True)]
        if _dot(rest, rest) > _INDEPENDENT**2:
            axes.append(axis)
            basis.append(rest)
    return axes


def _dot(a: list[float], b: list[float]) -> float:
    total = 0.0
    for x, y in zip(a, b, strict=True):
        total += x * y
    return total


@njit(cache=True, error_model="numpy")
def allocate_within(
    hessian: Array, gradient: Array, lowest: Array, highest: Array, thrust: Array
) -> None:
    """Minimise f' H f / 2 - g' f within limits by cyclic coordinate descent.

    It converges for every positive definite H (Bertsekas 2016, Nonlinear Programming, 3.7).

    Parameters
    ----------
    hessian, gradient : (n, n) and (n,)
    lowest, highest : (n,) [N]
    thrust : (n,) [N]
        The start of the search, and its result.
    """
    for _ in range(SWEEPS):
        for i in range(thrust.size):
            rest = gradient[i]
            for j in range(thrust.size):
                if j != i:
                    rest -= hessian[i, j] * thrust[j]
            thrust[i] = min(max(rest / hessian[i, i], lowest[i]), highest[i])
