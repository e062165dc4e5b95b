"""What a template tracker keeps, in two arrays: Numba takes 0.3 us for each that Python hands over.

The planes of all levels lie one behind the other in float32; what is kept of each level besides
them, and how to search, in float64. Compiled code looks at them through named tuples of views.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.simd import WIDTH
from seamark.sim.trackers.template.patches import MASK, NUMBERS, XS, Matrix, Plane

Numbers = NDArray[np.float64]
Store = NDArray[np.float32]
Levels = tuple[Matrix, Store]  # what is kept of each level, and the planes of all

# A level's planes. A patch has a rim of one pixel; the others start at the first inner pixel.
TEMPLATE, ALONG, DOWN, CODES, RAW, PATCH, ERRORS = range(7)
PLANES = 7
# What a level's frame holds: half the longer side, middle column and row [px]; the template's mean
# and deviation [grey]; grey values of one unit of the picture; columns; pixels; where the level
# begins in the store.
SCALE, COLUMN, ROW, MEAN, SIGMA, UNIT, COLUMNS, COUNT, BEGIN = range(9)
_FRAME = 9
_FACTS = _FRAME + 64


class Level(NamedTuple):
    """A template at one resolution, with the work arrays of its alignment."""

    planes: NDArray[np.float32]  # (PLANES, rows + 2, width)
    columns: Plane  # (3, width), see patches
    ys: Plane  # (rows,) normalised
    frame: Numbers  # (9,): see above
    curvature: Matrix  # (8, 8) of the mutual information


class Search(NamedTuple):
    """How the alignment goes on."""

    coarse_basis: Matrix  # (8, n): at most scale, rotation, translation, which cannot shear away
    basis: Matrix  # (8, n) of the warp
    weight: float  # of the image's own gradient: 0.5 ESM, 0 inverse, 1 forward
    adds: bool  # whether parameters are added; if not, warps are composed
    coarse_criterion: int  # SSD or ZNCC
    criterion: int  # SSD, ZNCC, MI
    levels: int
    coarse_iterations: int
    fine_iterations: int
    stop_px: float  # a step that moves every corner less is the last


def packed(search: Search) -> Numbers:
    """Return a search as numbers, for `search_of`."""
    bases = [np.array([basis.shape[1], *basis.ravel()]) for basis in search[:2]]
    return np.concatenate([np.array(search[2:], dtype=np.float64), *bases])


@njit(cache=True, nogil=True, error_model="numpy")
def search_of(numbers: Numbers) -> Search:
    """Return how to search."""
    first = 8
    coarse = int(numbers[first])
    second = first + 1 + 8 * coarse
    fine = int(numbers[second])
    return Search(
        numbers[first + 1 : second].reshape(8, coarse),
        numbers[second + 1 : second + 1 + 8 * fine].reshape(8, fine),
        numbers[0],
        numbers[1] != 0.0,
        int(numbers[2]),
        int(numbers[3]),
        int(numbers[4]),
        int(numbers[5]),
        int(numbers[6]),
        numbers[7],
    )


@njit(cache=True, nogil=True, error_model="numpy")
def level_of(levels: Levels, k: int) -> Level:
    """Return a level."""
    facts, store = levels
    frame = facts[k, :_FRAME]
    columns = int(frame[COLUMNS])
    rows = int(frame[COUNT]) // columns
    width = _width(columns)
    begin = int(frame[BEGIN])
    across = begin + PLANES * (rows + 2) * width
    down = across + 3 * width
    return Level(
        store[begin:across].reshape(PLANES, rows + 2, width),
        store[across:down].reshape(3, width),
        store[down : down + rows],
        frame,
        facts[k, _FRAME:].reshape(8, 8),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _width(columns: int) -> int:
    """Return the length of a plane's rows: whole lanes and a vector more, for the rim."""
    return ((columns + 2 + WIDTH - 1) // WIDTH + 1) * WIDTH


def empty_levels(columns: int, rows: int, count: int) -> Levels:
    """Return facts and store of levels without a template yet, each half as large.

    A level's picture is in sums of pixels (pyramid.py): its unit is a quarter each.
    """
    facts = np.zeros((count, _FACTS))
    scale, column, row = max(columns, rows) / 2, (columns - 1) / 2, (rows - 1) / 2
    end = 0
    for k in range(count):
        across, down = max(columns >> k, 1), max(rows >> k, 1)
        facts[k, :_FRAME] = scale, column, row, 0.0, 1.0, 0.25**k, across, across * down, end
        end += (PLANES * (down + 2) + 3) * _width(across) + down
        scale, column, row = scale / 2, (column - 0.5) / 2, (row - 0.5) / 2
    store = np.zeros(end, np.float32)
    for k in range(count):
        level = level_of((facts, store), k)
        numbers = np.arange(level.columns.shape[1])
        level.columns[NUMBERS] = numbers
        level.columns[XS] = (numbers - level.frame[COLUMN]) / level.frame[SCALE]
        level.columns[MASK, : int(level.frame[COLUMNS])] = 1.0
        level.ys[:] = (np.arange(len(level.ys)) - level.frame[ROW]) / level.frame[SCALE]
    return facts, store
