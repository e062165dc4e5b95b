"""The coarse search: prototypes of all headings over an image at all scales.

An image is reduced so that a thing is about ten cells long, and compared with the mean of what its
kind looks like. Light things on a dark ground look like dark ones on a light ground there, so the
sign of the correlation does not count. What is found is a place that a thing may be at.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.bottom.things import NAMES
from seamark.sim.detectors.template.frame import CELLS, SIDE, WINDOW, across, weight
from seamark.sim.detectors.template.library import Library
from seamark.sim.numerics.libm import PI, cos, sin
from seamark.sim.numerics.simd import (
    WIDTH,
    f32x16,
    load,
    maximum,
    select_greater,
    store,
)

_SCALE_STEP = 1.2  # E
_LEAST_VARIANCE = 0.3  # [grey²] of a cell, E: below it there is only noise
_APART = 0.25  # of a length, E


class Prototypes(NamedTuple):
    """What is searched with windows of one size."""

    side: int  # [cell] of the window
    weights: NDArray[np.float32]  # (n, side * side), n a multiple of four
    headings: NDArray[np.float64]  # (n,) [rad]
    lengths: tuple[float, ...]  # [px] of things, each a level of the search


class Family(NamedTuple):
    """Kinds that have one prototype."""

    kinds: tuple[str, ...]
    side: int
    turns: int  # headings in half a turn, or in a quarter if it looks the same after one
    quarter: bool
    lengths: tuple[float, float]  # [px] of the smallest and the largest


FAMILIES = (
    Family(("box",), 12, 8, False, (46.0, 110.0)),
    Family(("amphora",), 12, 8, False, (46.0, 150.0)),
    Family(("pipe", "connector", "anode"), 12, 8, False, (40.0, 150.0)),
    Family(("panel",), 12, 8, False, (46.0, 110.0)),
    Family(("aruco", "apriltag"), 8, 4, True, (15.0, 62.0)),
)


def prototypes(library: Library) -> tuple[Prototypes, ...]:
    """Return the prototypes of all families, those with windows of one size together."""
    found = []
    for side in sorted({family.side for family in FAMILIES}):
        families = [family for family in FAMILIES if family.side == side]
        weights, headings = [], []
        for family in families:
            mean = _mean(library, family)
            for turn in range(family.turns):
                heading = PI * turn / family.turns * (0.5 if family.quarter else 1.0)
                weights.append(turned(mean, heading, side))
                headings.append(heading)
        low = min(family.lengths[0] for family in families)
        high = max(family.lengths[1] for family in families)
        lengths = [low * 1.06]
        while lengths[-1] * _SCALE_STEP < high:
            lengths.append(lengths[-1] * _SCALE_STEP)
        found.append(Prototypes(side, np.concatenate(weights), np.array(headings), tuple(lengths)))
    return tuple(found)


def _mean(library: Library, family: Family) -> NDArray[np.float64]:
    """Return the mean look of a family, dark on light, the same after half a turn."""
    total = np.zeros(CELLS)
    for kind in family.kinds:
        for row in np.flatnonzero(library.kinds == NAMES.index(kind)):
            patch = library.patches[row].astype(np.float64)
            inside = _inside(library.proportions[row])
            total += -patch if not family.quarter and inside @ patch > 0.0 else patch
    return total


def _inside(proportion: float) -> NDArray[np.float64]:
    """Return 1 for cells inside a thing and 0 for the others, (CELLS,)."""
    at = np.array([across(cell) for cell in range(SIDE)])
    rows, columns = np.abs(at) < 0.45 * proportion, np.abs(at) < 0.45
    return np.outer(rows, columns).astype(np.float64).ravel()


@njit(cache=True, nogil=True, error_model="numpy")
def turned(mean: NDArray[np.float64], heading: float, side: int) -> NDArray[np.float32]:
    """Return the weights (1, side * side) of a prototype at a heading: their sum is 0."""
    greys, shares = np.zeros(side * side), np.zeros(side * side)
    cosine, sine = cos(heading), sin(heading)
    for at in range(side * side):
        u = WINDOW * ((at % side + 0.5) / side - 0.5)
        v = WINDOW * ((at // side + 0.5) / side - 0.5)
        x, y = cosine * u + sine * v, cosine * v - sine * u
        column = (x / WINDOW + 0.5) * SIDE - 0.5
        row = (y / WINDOW + 0.5) * SIDE - 0.5
        if min(column, row) < 0.0 or max(column, row) > SIDE - 1.001:
            continue
        i, j = int(column), int(row)
        a, b = column - i, row - j
        shares[at] = weight(y)
        upper = mean[j * SIDE + i] + a * (mean[j * SIDE + i + 1] - mean[j * SIDE + i])
        below = (j + 1) * SIDE + i
        lower = mean[below] + a * (mean[below + 1] - mean[below])
        greys[at] = (upper + b * (lower - upper)) / np.sqrt(weight(y))
    middle = np.sum(shares * greys) / np.sum(shares)
    energy = np.sum(shares * (greys - middle) ** 2)
    out = np.empty((1, side * side), np.float32)
    out[0] = shares * (greys - middle) / np.sqrt(energy * np.sum(shares))
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def summed(image: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Return the sums of all greys above and left of each corner of a pixel, (H + 1, W + 1)."""
    rows, columns = image.shape
    out = np.zeros((rows + 1, columns + 1), np.int64)
    for r in range(rows):
        total = 0
        for c in range(columns):
            total += image[r, c]
            out[r + 1, c + 1] = out[r, c + 1] + total
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _reduced(sums: NDArray[np.int64], cell: float, margin: int) -> NDArray[np.float32]:
    """Return an image of cells of so many pixels, with its border repeated beyond it."""
    rows = int((sums.shape[0] - 1) / cell)
    columns = int((sums.shape[1] - 1) / cell)
    width = (columns + 2 * margin + 2 * WIDTH) // WIDTH * WIDTH
    out = np.empty((rows + 2 * margin, width), np.float32)
    for r in range(rows + 2 * margin):
        row = min(max(r - margin, 0), rows - 1)
        top, bottom = int(row * cell), int((row + 1) * cell)
        for c in range(width):
            column = min(max(c - margin, 0), columns - 1)
            left, right = int(column * cell), int((column + 1) * cell)
            total = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
            out[r, c] = total / ((bottom - top) * (right - left))
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _spreads(image: NDArray[np.float32], side: int) -> NDArray[np.float32]:
    """Return one over the spread of each window of so many cells, at its first cell."""
    rows, columns = image.shape[0] - side + 1, image.shape[1] - side + 1
    out = np.zeros((rows, image.shape[1]), np.float32)
    sums, squares = np.zeros(image.shape[1]), np.zeros(image.shape[1])
    totals, energies = np.empty(columns), np.empty(columns)
    for r in range(image.shape[0]):
        for c in range(image.shape[1]):
            value = float(image[r, c])
            sums[c] += value
            squares[c] += value * value
            if r >= side:
                gone = float(image[r - side, c])
                sums[c] -= gone
                squares[c] -= gone * gone
        if r < side - 1:
            continue
        totals[:], energies[:] = 0.0, 0.0
        for k in range(side):  # outside, so that all columns are added at the same time
            for c in range(columns):
                totals[c] += sums[c + k]
                energies[c] += squares[c + k]
        n = side * side
        for c in range(columns):
            variance = energies[c] / n - (totals[c] / n) ** 2
            out[r - side + 1, c] = 1.0 / np.sqrt(max(variance, 0.0) + _LEAST_VARIANCE)
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _responses(
    image: NDArray[np.float32], weights: NDArray[np.float32], side: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the best fit of any prototype at each window, and which it is."""
    rows = image.shape[0] - side + 1
    columns = (image.shape[1] - side + 1) // WIDTH * WIDTH
    best, which = np.zeros((rows, columns), np.float32), np.zeros((rows, columns), np.float32)
    minus = f32x16(-1.0)
    for r in range(rows):
        for c in range(0, columns, WIDTH):
            top, index = f32x16(0.0), f32x16(0.0)
            for t in range(0, weights.shape[0], 4):
                s0, s1, s2, s3 = f32x16(0.0), f32x16(0.0), f32x16(0.0), f32x16(0.0)
                for j in range(side):
                    for i in range(side):
                        cells, k = load(image, r + j, c + i), j * side + i
                        s0 = s0 + cells * f32x16(weights[t, k])
                        s1 = s1 + cells * f32x16(weights[t + 1, k])
                        s2 = s2 + cells * f32x16(weights[t + 2, k])
                        s3 = s3 + cells * f32x16(weights[t + 3, k])
                s0, s1 = maximum(s0, minus * s0), maximum(s1, minus * s1)
                s2, s3 = maximum(s2, minus * s2), maximum(s3, minus * s3)
                index = select_greater(s0, top, f32x16(t), index)
                top = maximum(s0, top)
                index = select_greater(s1, top, f32x16(t + 1), index)
                top = maximum(s1, top)
                index = select_greater(s2, top, f32x16(t + 2), index)
                top = maximum(s2, top)
                index = select_greater(s3, top, f32x16(t + 3), index)
                top = maximum(s3, top)
            store(best, r, c, top)
            store(which, r, c, index)
    return best, which


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _is_passed(best: NDArray[np.float32], r: int, c: int, columns: int) -> bool:
    """Return whether one of the neighbours fits better."""
    for j in range(max(r - 1, 0), min(r + 2, best.shape[0])):
        for i in range(max(c - 1, 0), min(c + 2, columns)):
            if best[j, i] > best[r, c]:
                return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _peaks(
    best: NDArray[np.float32],
    which: NDArray[np.float32],
    spreads: NDArray[np.float32],
    inner: int,
) -> NDArray[np.float64]:
    """Return the places that fit better than their neighbours: (n, 4) fit, column, row, which."""
    rows, columns = best.shape[0], inner
    for r in range(rows):
        for c in range(best.shape[1]):
            best[r, c] *= spreads[r, c]
    found = np.empty((rows * columns, 4))
    n = 0
    for r in range(rows):
        for c in range(columns):
            here = best[r, c]
            if here > 0.0 and not _is_passed(best, r, c, columns):
                found[n, 0], found[n, 1], found[n, 2], found[n, 3] = here, c, r, which[r, c]
                n += 1
    return found[:n]


def places(
    image: NDArray[np.uint8], sets: tuple[Prototypes, ...], most: int
) -> NDArray[np.float64]:
    """Return the poses (n, 4) at which things may be: so many of each size, none twice in one."""
    sums = summed(image)
    every = [np.empty((0, 5))]
    for each in sets:
        margin = each.side // 4
        for length in each.lengths:
            cell = WINDOW * length / each.side
            if int(min(image.shape) / cell) + 2 * margin < each.side:
                continue  # an image that is smaller than the window
            reduced = _reduced(sums, cell, margin)
            best, which = _responses(reduced, each.weights, each.side)
            inner = min(int(image.shape[1] / cell) + 2 * margin - each.side + 1, best.shape[1])
            peaks = _peaks(best, which, _spreads(reduced, each.side), inner)
            middle = 0.5 * each.side - margin
            table = np.column_stack(
                [
                    peaks[:, 0],
                    (peaks[:, 1:3] + middle) * cell - 0.5,
                    np.full(len(peaks), length),
                    each.headings[peaks[:, 3].astype(np.int64)],
                ]
            )
            order = np.argsort(-table[:, 0], kind="stable")
            every.append(_apart(table[order], most))
    return np.concatenate(every)[:, 1:]


@njit(cache=True, nogil=True, error_model="numpy")
def _apart(table: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """Return the first rows of which none is at the place and of the size of another."""
    kept = np.empty((most, table.shape[1]))
    n = 0
    for row in table:
        alone = True
        for k in range(n):
            other = kept[k]
            near = _APART * row[3]
            if abs(row[1] - other[1]) < near and abs(row[2] - other[2]) < near:
                alone = False
                break
        if alone:
            kept[n] = row
            n += 1
            if n == most:
                break
    return kept[:n]
