"""Ways along a polyline: points that are joined by straight lines, by arc length from the first."""

import math

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array


def starts_of(points: Array) -> Array:
    """Return the arc length at each of the points (k, 3), (k,); no two in a row may coincide."""
    steps = np.diff(points, axis=0)
    squares = steps * steps
    lengths = np.sqrt(squares[:, 0] + squares[:, 1] + squares[:, 2])
    if not (lengths > 0.0).all():
        raise ValueError("two points of a polyline in a row must not coincide")
    starts = np.zeros(len(points))
    for i, length in enumerate(lengths.tolist()):
        starts[i + 1] = starts[i] + length
    return starts


@njit(cache=True, error_model="numpy")
def at_length(points: Array, starts: Array, along: float, out: Array) -> None:
    """Write the point at an arc length, and the direction there, to `out`, (6,).

    Before the first and beyond the last point it is that point.
    """
    last = starts.size - 2
    i = 0
    while i < last and starts[i + 1] <= along:
        i += 1
    length = starts[i + 1] - starts[i]
    share = min(max((along - starts[i]) / length, 0.0), 1.0)
    for axis in range(3):
        step = points[i + 1, axis] - points[i, axis]
        out[axis] = points[i, axis] + share * step
        out[3 + axis] = step / length


@njit(cache=True, error_model="numpy")
def nearest(
    points: Array, starts: Array, position: Array, first: float, last: float, out: Array
) -> tuple[float, float]:
    """Return arc length and distance of the point of a piece that is nearest to a position (3,).

    The piece goes from arc length `first` to `last`. The point, and the direction there, are
    written to `out`, (6,). Of points that are equally near it is the first.
    """
    best, along = math.inf, first
    for i in range(starts.size - 1):
        begin, end = max(starts[i], first), min(starts[i + 1], last)
        if begin > end:
            continue
        length = starts[i + 1] - starts[i]
        dot = 0.0
        for axis in range(3):
            dot += (points[i + 1, axis] - points[i, axis]) * (position[axis] - points[i, axis])
        here = min(max(starts[i] + dot / length, begin), end)
        share = (here - starts[i]) / length
        square = 0.0
        for axis in range(3):
            step = points[i + 1, axis] - points[i, axis]
            off = position[axis] - points[i, axis] - share * step
            square += off * off
        if square < best:
            best, along = square, here
            for axis in range(3):
                step = points[i + 1, axis] - points[i, axis]
                out[axis] = points[i, axis] + share * step
                out[3 + axis] = step / length
    return along, math.sqrt(best)
