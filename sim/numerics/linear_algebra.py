"""Linear algebra with the same bits on every processor; BLAS and LAPACK give other last bits."""

import numpy as np

from seamark.sim.numerics.arrays import Array


def inverse(matrix: Array) -> Array:
    """Return the inverse of a symmetric positive definite matrix, (n, n), by Gauss-Jordan.

    A positive definite matrix needs no pivoting.

    Raises
    ------
    ValueError
        The matrix is not positive definite.
    """
    n = len(matrix)
    rows = [[*map(float, row), *(float(i == j) for j in range(n))] for i, row in enumerate(matrix)]
    for i in range(n):
        pivot = rows[i][i]
        if not pivot > 0.0:
            raise ValueError("the matrix is not positive definite")
        rows[i] = [value / pivot for value in rows[i]]
        for j in range(n):
            if j != i:
                factor = rows[j][i]
                rows[j] = [a - factor * b for a, b in zip(rows[j], rows[i], strict=True)]
    return np.array([row[n:] for row in rows])
