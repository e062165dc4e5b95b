"""What leaves a fleet at every step: copies of columns of its telemetry, made by all threads."""

from numba import njit

from seamark.sim.numerics.arrays import Array, Integers
from seamark.sim.numerics.borrowed import borrowed
from seamark.sim.numerics.lanes import LANES


@njit(cache=True, nogil=True, error_model="numpy")
def copy_columns(first: int, last: int, columns: Integers, rows: Array, out: Array) -> None:
    """Copy columns (k,) of the rows (n, width) of some blocks of vehicles to `out`, (n, k)."""
    columns, rows, out = borrowed(columns), borrowed(rows), borrowed(out)
    for i in range(first * LANES, min(last * LANES, out.shape[0])):
        for j in range(columns.size):
            out[i, j] = rows[i, columns[j]]
