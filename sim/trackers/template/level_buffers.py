"""The data of a template tracker in few arrays: passing each one to Numba takes 0.3 us.

The planes of all pyramid levels are stored one after the other in float32; the numbers of each
level and the settings of the search in float64. Compiled code gets them as named tuples of views.

What an alignment only needs while it runs is elsewhere, in a bench that many trackers share, one
after the other: thousands of them would not fit into a processor's caches.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.simd import WIDTH, prefetch
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.trackers.template.patches import MASK, NUMBERS, XS, Matrix, Plane

Numbers = NDArray[np.float64]
PlaneStore = NDArray[np.float32]
Bench = NDArray[np.float32]  # as of `bench_for`
PyramidLevels = tuple[Matrix, PlaneStore, Bench]  # numbers of each level, planes of all

# The planes that a level keeps, and those on the bench, which are as large. A template has a rim of
# one pixel, as a patch; the others start at the first inner pixel.
TEMPLATE, QUANTISED = range(2)
_KEPT = 2
RAW, PATCH, ERRORS = range(3)
_ON_BENCH = 3
# The frame of a level: half the longer side, central column and row [px]; mean and standard
# deviation [grey] of the template; grey values per unit of the image; columns; pixels; offset of
# the level in the store.
SCALE, COLUMN, ROW, MEAN, SIGMA, UNIT, COLUMNS, COUNT, BEGIN = range(9)
_FRAME = 9
_LEVEL_NUMBERS = _FRAME + 64


class PyramidLevel(NamedTuple):
    """A template at one resolution, with the buffers of its alignment."""

    planes: NDArray[np.float32]  # (2, rows + 2, width)
    bench: NDArray[np.float32]  # (3, rows + 2, width)
    columns: Plane  # (3, width), see patches
    ys: Plane  # (rows,) normalised
    frame: Numbers  # (9,): see above
    hessian: Matrix  # (8, 8) of the mutual information


class SearchSettings(NamedTuple):
    """Settings of the alignment."""

    coarse_basis: Matrix  # (8, n): at most scale, rotation and translation, which are robust
    basis: Matrix  # (8, n) of the warp
    weight: float  # of the image's own gradient: 0.5 ESM, 0 inverse, 1 forward
    is_additive: bool  # whether parameters are added instead of warps composed
    coarse_criterion: int  # SSD or ZNCC
    criterion: int  # SSD, ZNCC, MI
    levels: int
    coarse_iterations: int
    fine_iterations: int
    stop_px: float  # stop when no corner moves farther
    second_levels: int  # pyramid levels of the second search; 0: there is none
    smooth_image: bool  # whether the image is smoothed before it is sampled, or the patch after


def pack_search(search: SearchSettings) -> Numbers:
    """Return the settings as an array for `unpack_search`."""
    bases = [np.array([basis.shape[1], *basis.ravel()]) for basis in search[:2]]
    return np.concatenate([np.array(search[2:], dtype=np.float64), *bases])


@njit(cache=True, nogil=True, error_model="numpy")
def unpack_search(numbers: Numbers) -> SearchSettings:
    """Return the settings that `pack_search` packed."""
    first = 10
    coarse = int(numbers[first])
    second = first + 1 + 8 * coarse
    fine = int(numbers[second])
    return SearchSettings(
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
        int(numbers[8]),
        numbers[9] != 0.0,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def pyramid_level(levels: PyramidLevels, k: int) -> PyramidLevel:
    """Return the views of one level."""
    level_numbers, store, bench = levels
    frame = level_numbers[k, :_FRAME]
    columns = int(frame[COLUMNS])
    rows = int(frame[COUNT]) // columns
    width = _width(columns)
    begin = int(frame[BEGIN])
    across = begin + _KEPT * (rows + 2) * width
    down = across + 3 * width
    used = _ON_BENCH * (rows + 2) * width
    return PyramidLevel(
        store[begin:across].reshape(_KEPT, rows + 2, width),
        bench[:used].reshape(_ON_BENCH, rows + 2, width),
        store[across:down].reshape(3, width),
        store[down : down + rows],
        frame,
        level_numbers[k, _FRAME:].reshape(8, 8),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _width(columns: int) -> int:
    """Return the row length of a plane: whole vectors, and one more for the rim."""
    return ((columns + 2 + WIDTH - 1) // WIDTH + 1) * WIDTH


@uncounted
def fetch_templates(level_numbers: Matrix, store: PlaneStore, levels: int) -> None:
    """Ask for the templates of some levels, which are read later.

    Between two images, the trackers of other vehicles displace them from the caches.
    """
    for k in range(levels):
        columns = int(level_numbers[k, COLUMNS])
        rows = int(level_numbers[k, COUNT]) // columns + 2
        begin = int(level_numbers[k, BEGIN])
        for at in range(begin, begin + rows * _width(columns), WIDTH):
            prefetch(store, at)


def bench_size(level_numbers: Matrix) -> int:
    """Return how many numbers a bench for a tracker of these levels has."""
    columns, count = (int(number) for number in level_numbers[0, [COLUMNS, COUNT]])
    return int(_ON_BENCH * (count // columns + 2) * _width(columns))


@njit(cache=True, nogil=True, error_model="numpy")
def bench_for(size: int) -> Bench:
    """Return a bench of at least this size.

    Its values must be finite at first: those beyond a patch are multiplied by zero.
    """
    return np.zeros(size, np.float32)


def allocate_levels(columns: int, rows: int, count: int) -> tuple[Matrix, PlaneStore]:
    """Return facts and store of levels without a template, each of half the size.

    The images of coarser levels are sums of pixels (pyramid.py), so their unit is a quarter.
    """
    level_numbers = np.zeros((count, _LEVEL_NUMBERS))
    scale, column, row = max(columns, rows) / 2, (columns - 1) / 2, (rows - 1) / 2
    end = 0
    for k in range(count):
        across, down = max(columns >> k, 1), max(rows >> k, 1)
        level_numbers[k, :_FRAME] = (
            scale,
            column,
            row,
            0.0,
            1.0,
            0.25**k,
            across,
            across * down,
            end,
        )
        end += (_KEPT * (down + 2) + 3) * _width(across) + down
        scale, column, row = scale / 2, (column - 0.5) / 2, (row - 0.5) / 2
    store = np.zeros(end, np.float32)
    levels = (level_numbers, store, bench_for(bench_size(level_numbers)))
    for k in range(count):
        level = pyramid_level(levels, k)
        numbers = np.arange(level.columns.shape[1])
        level.columns[NUMBERS] = numbers
        level.columns[XS] = (numbers - level.frame[COLUMN]) / level.frame[SCALE]
        level.columns[MASK, : int(level.frame[COLUMNS])] = 1.0
        level.ys[:] = (np.arange(len(level.ys)) - level.frame[ROW]) / level.frame[SCALE]
    return level_numbers, store
