"""A pipe on a flat seabed: its axis, its radius, and where sand covers it.

The axis lies in the plane of the seabed, so the upper half of the pipe stands out. Cameras and
sonars cast rays against this one description.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array

RAMP_M = 0.5  # E: over which the sand rises from the foot of the pipe to its top


class Pipe(NamedTuple):
    """A pipe as compiled code takes it."""

    axis_m: Array  # (k, 2) north and east of its points, which straight lines join
    starts_m: Array  # (k,) arc length at each of them
    seabed_m: float  # depth of the seabed and of the axis
    radius_m: float
    covered_m: Array  # (m, 2) arc lengths from and to which no part is above the sand
    coat: Array  # (3,) albedo of the coating in red, green and blue
    seed: int  # of joints and growth


def pipe_along(axis_m: Array, seabed_m: float, radius_m: float, *, seed: int) -> Pipe:
    """Return a bare pipe, black, along points (k, 2) of which no two in a row coincide."""
    steps = np.diff(axis_m, axis=0)
    lengths = np.sqrt(steps[:, 0] * steps[:, 0] + steps[:, 1] * steps[:, 1])
    starts = np.zeros(len(axis_m))
    for i, length in enumerate(lengths.tolist()):
        starts[i + 1] = starts[i] + length
    black = np.array([0.1, 0.1, 0.1])
    return Pipe(axis_m, starts, seabed_m, radius_m, np.empty((0, 2)), black, seed)


@njit(cache=True, nogil=True, error_model="numpy")
def sand_on(pipe: Pipe, along: float) -> float:
    """Return up to which height the sand reaches at an arc length, as a share of the radius.

    0: bare; 1 or more: covered.
    """
    most = 0.0
    for k in range(pipe.covered_m.shape[0]):
        outside = max(pipe.covered_m[k, 0] - along, along - pipe.covered_m[k, 1])
        most = max(most, 1.0 - outside / RAMP_M)
    return most
