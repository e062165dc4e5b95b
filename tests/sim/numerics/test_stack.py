"""Small arrays on the stack of compiled functions."""

import numpy as np
from numba import njit

from seamark.sim.numerics.stack import on_stack


@njit
def sums(count: int) -> float:
    total = 0.0
    for k in range(count):
        matrix, row = on_stack(np.float64, 2, 3), on_stack(np.float32, 16)
        for i in range(2):
            for j in range(3):
                matrix[i, j] = 10 * i + j + k
        row[:] = matrix[1, 2]
        total += row.sum() + matrix[0].sum()
    return total


def test_arrays_on_the_stack_keep_their_elements_apart() -> None:
    assert sums(3) == sum(16 * (12 + k) + 3 + 3 * k for k in range(3))


def test_no_memory_is_counted_for_an_array_on_the_stack() -> None:
    @njit
    def corner(value: float) -> float:
        matrix = on_stack(np.float64, 3, 3)
        matrix[2, 2] = value
        return matrix[2, 2]  # type: ignore[no-any-return]

    assert corner(4.0) == 4.0
    assert "NRT_" not in corner.inspect_asm(corner.signatures[0])
