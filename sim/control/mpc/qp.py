"""A quadratic program within limits, solved by a fixed number of operations.

    minimise  x' H x / 2 + g' x   subject to  low <= A x <= high

H and A are constant, so everything that needs an inverse is computed once. The solution without
limits is tried first; where it breaks one, the alternating direction method of multipliers decides
(ADMM; Stellato et al. 2020, OSQP: an operator splitting solver for quadratic programs, algorithm 1,
with a fixed step size). No BLAS or LAPACK, whose last bits depend on the processor.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.linear_algebra import inverse

ITERATIONS = 50  # E: a row is then mostly within 0.05 of its limits; the next search goes on
RELAXATION = 1.6  # S: alpha of OSQP
REGULARISATION = 1e-6  # S: sigma of OSQP, as a share of the mean of H's diagonal


class Problem(NamedTuple):
    """What does not change from one program to the next."""

    inverse: Array  # (n, n) of H
    step_inverse: Array  # (n, n) of H + sigma 1 + rho A' A
    rows: Array  # (m, n) A
    sigma: float
    rho: float  # step size


class Iterates(NamedTuple):
    """Where a search starts, and where it ended."""

    solution: Array  # (n,) x
    values: Array  # (m,) of the rows, within the limits
    multipliers: Array  # (m,) of the rows


def problem(hessian: Array, rows: Array) -> Problem:
    """Prepare a program.

    Parameters
    ----------
    hessian : (n, n)
        H, symmetric and positive definite.
    rows : (m, n)
        A; without a row that is not zero there is no limit.

    Raises
    ------
    ValueError
        H is not positive definite.
    """
    size = len(hessian)
    entries = [[float(value) for value in row] for row in rows]
    gram = [[sum(row[i] * row[j] for row in entries) for j in range(size)] for i in range(size)]
    mean = sum(float(hessian[i, i]) for i in range(size)) / size
    effect = sum(gram[i][i] for i in range(size))
    rho = mean * size / effect if effect > 0.0 else mean
    sigma = REGULARISATION * mean
    step = hessian + sigma * np.eye(size) + rho * np.array(gram)
    return Problem(inverse(hessian), inverse(step), np.array(rows), sigma, rho)


def iterates(of: Problem) -> Iterates:
    """Return where the first search starts: at zero."""
    rows, size = of.rows.shape
    return Iterates(np.zeros(size), np.zeros(rows), np.zeros(rows))


@njit(cache=True, error_model="numpy")
def solve(of: Problem, gradient: Array, low: Array, high: Array, found: Iterates) -> None:
    """Write the solution to `found`, which is also where the search starts.

    Parameters
    ----------
    gradient : (n,)
        g.
    low, high : (m,)
        Limits of the rows; they need not leave any solution, and then the rows come near them.
    """
    free, rows = np.empty(found.solution.size), np.empty(found.values.size)
    _multiply(of.inverse, gradient, free)
    free *= -1.0
    _multiply(of.rows, free, rows)
    if np.all((low <= rows) & (rows <= high)):
        found.solution[:], found.values[:], found.multipliers[:] = free, rows, 0.0
        return
    for _ in range(ITERATIONS):
        _iterate(of, gradient, low, high, found, free, rows)


@njit(cache=True, error_model="numpy")
def _iterate(
    of: Problem,
    gradient: Array,
    low: Array,
    high: Array,
    found: Iterates,
    free: Array,
    rows: Array,
) -> None:
    """Make one step of the method; `free` (n,) and `rows` (m,) are for what is in between."""
    solution, values, multipliers = found
    wanted = of.sigma * solution - gradient
    for k in range(values.size):
        push = of.rho * values[k] - multipliers[k]
        for j in range(solution.size):
            wanted[j] += of.rows[k, j] * push
    _multiply(of.step_inverse, wanted, free)
    _multiply(of.rows, free, rows)
    for j in range(solution.size):
        solution[j] = RELAXATION * free[j] + (1.0 - RELAXATION) * solution[j]
    for k in range(values.size):
        row = RELAXATION * rows[k] + (1.0 - RELAXATION) * values[k]
        values[k] = min(max(row + multipliers[k] / of.rho, low[k]), high[k])
        multipliers[k] += of.rho * (row - values[k])


@njit(cache=True, error_model="numpy")
def _multiply(matrix: Array, vector: Array, out: Array) -> None:
    """Write the product of a matrix and a vector, its terms added in their order."""
    for i in range(matrix.shape[0]):
        out[i] = 0.0
        for j in range(matrix.shape[1]):
            out[i] += matrix[i, j] * vector[j]
