"""The frame in which things are compared: a square around a thing, turned along its length.

It has SIDE x SIDE cells and is WINDOW times as wide as the thing is long. Cells near the thing's
axis weigh more: that is where every kind of thing has its body.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

SIDE = 16
CELLS = SIDE * SIDE  # a multiple of the width of vectors
WINDOW = 1.25  # E: a margin of bottom belongs to the picture of a thing
_FALL = 4.0  # E: how fast the weight falls with the distance from the axis, in lengths
_LEAST_SPREAD = 1e-6

Patches = NDArray[np.float32]  # (n, CELLS)


@njit(cache=True, nogil=True, error_model="numpy")
def across(cell: int) -> float:
    """Return where the middle of a row or column is, in lengths of the thing."""
    return WINDOW * ((cell + 0.5) / SIDE - 0.5)


@njit(cache=True, nogil=True, error_model="numpy")
def weight(y: float) -> float:
    """Return the weight of a place so many lengths beside the axis."""
    return float(1.0 / np.sqrt(1.0 + (_FALL * y) ** 4))


@njit(cache=True, nogil=True, error_model="numpy")
def normalise(patch: Patches) -> float:
    """Give a patch (1, CELLS) of greys the weighted mean 0 and the length 1; return its spread.

    The product of two such patches is their zero-mean normalised cross-correlation.
    """
    total, mean = 0.0, 0.0
    for row in range(SIDE):
        inside = 0.0
        for cell in range(row * SIDE, (row + 1) * SIDE):
            inside += patch[0, cell]
        mean += weight(across(row)) * inside
        total += weight(across(row)) * SIDE
    mean /= total
    energy = 0.0
    for row in range(SIDE):
        inside = 0.0
        for cell in range(row * SIDE, (row + 1) * SIDE):
            off = patch[0, cell] - mean
            inside += off * off
        energy += weight(across(row)) * inside
    for row in range(SIDE):
        scale = np.sqrt(weight(across(row)) / max(energy, _LEAST_SPREAD))
        for cell in range(row * SIDE, (row + 1) * SIDE):
            patch[0, cell] = (patch[0, cell] - mean) * scale
    return float(np.sqrt(energy / total))
