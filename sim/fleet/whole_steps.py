"""A control step of vehicles with cameras, compiled: all that follows from the last one.

In one call, because the threads that share the vehicles sleep in between: on a virtual machine, to
wake one takes a fifth of a millisecond, in which 256 vehicles move and sense.
"""

from typing import NamedTuple

from numba import njit

from seamark.sim.camera.survey import Survey
from seamark.sim.fleet.steps import Shared, sense_all, step_all
from seamark.sim.fleet.tables import Tables
from seamark.sim.fleet.views import (
    Found,
    Image,
    Shots,
    Trackers,
    motions_of,
    show_all,
    track_all,
)
from seamark.sim.numerics.arrays import Array, Flags, Integers
from seamark.sim.numerics.lanes import LANES


class Scratch(NamedTuple):
    """What a step remembers of each vehicle while it lasts."""

    going: Flags  # (n,) which are to move; then which of them did, and touch nothing
    seeing: Flags  # (n,) and have a finite state
    motions: Array  # (n, 12) zero before
    frames: Integers  # (n,) of the levels' first images; then of the present ones
    blurred: bool  # whether images depend on velocities


@njit(cache=True, nogil=True, error_model="numpy")
def step_and_see(
    first: int,
    last: int,
    actions: Array,
    fleet: tuple[Shared, Tables, Scratch],
    trackers: Trackers | None,
    shots: Shots | None,
    images: Image | None,
    surveys: Survey | None,
) -> None:
    """Do what `step_all` does, track, sense, and render the images that arrive.

    Vehicles that may touch something are left as `step_all` leaves them. Without `trackers` these
    are the ground truth; `shots` and what follows are as in `show_all`, and None without images.
    """
    shared, tables, scratch = fleet
    going, seeing, motions, frames, blurred = scratch
    outputs, progress = tables.outputs, tables.progress
    step_all(first, last, going, actions, shared, tables)
    for i in range(first * LANES, min(last * LANES, going.size)):
        going[i] = going[i] and not (outputs.diverged[i] or outputs.touching[i])
        frames[i] += progress.step[i]
    motions_of(first, last, going, tables.motion.state, blurred, motions, seeing)
    if trackers is not None:
        found = Found(outputs.corners, outputs.visible)
        track_all(first, last, seeing, motions, frames, trackers, found)
        sense_all(first, last, going, shared, tables)
    if shots is not None:
        show_all(first, last, seeing, (motions, frames), progress, shots, images, surveys)
