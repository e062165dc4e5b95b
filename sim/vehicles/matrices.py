"""Small matrices in plain arithmetic: BLAS and libm may round differently on other processors."""

from collections.abc import Sequence

import numpy as np

from seamark.sim.numerics.arrays import Array

_Rows = Sequence[Sequence[float]] | Array


def multiplied(a: _Rows, b: _Rows) -> Array:
    """Return the product of two matrices."""
    columns = range(len(b[0]))
    return np.array([[_dot(row, [r[j] for r in b]) for j in columns] for row in a])


def applied(a: _Rows, v: Sequence[float] | Array) -> Array:
    """Return a matrix times a vector."""
    return np.array([_dot(row, v) for row in a])


def shifted(matrix: Array, point: Sequence[float] | Array) -> Array:
    """Return a mass matrix about a point as that about the origin, (6, 6)."""
    x, y, z = point
    there = np.eye(6)
    there[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return multiplied(there.T, multiplied(matrix, there))


def turned(matrix: Array, turn: Array) -> Array:
    """Return a mass matrix in axes which see its own turned by `turn` (3, 3), (6, 6)."""
    both = np.zeros((6, 6))
    both[:3, :3] = both[3:, 3:] = turn
    return multiplied(both, multiplied(matrix, both.T))


def quaternion_of(turn: Array) -> tuple[float, float, float, float]:
    """Return the quaternion w x y z of a rotation (3, 3), from its largest component."""
    trace = turn[0, 0] + turn[1, 1] + turn[2, 2]
    largest = int(np.argmax([trace, turn[0, 0], turn[1, 1], turn[2, 2]]))
    if largest == 0:
        values = np.array(
            [
                1.0 + trace,
                turn[2, 1] - turn[1, 2],
                turn[0, 2] - turn[2, 0],
                turn[1, 0] - turn[0, 1],
            ]
        )
    else:
        i = largest - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        values = np.empty(4)
        values[0] = turn[k, j] - turn[j, k]
        values[1 + i] = 1.0 + turn[i, i] - turn[j, j] - turn[k, k]
        values[1 + j], values[1 + k] = turn[j, i] + turn[i, j], turn[k, i] + turn[i, k]
    w, x, y, z = map(float, values / np.sqrt(_dot(values, values)))
    return w, x, y, z


def _dot(a: Sequence[float] | Array, b: Sequence[float] | Array) -> float:
    total = 0.0
    for x, y in zip(a, b, strict=True):
        total += float(x) * float(y)
    return total
