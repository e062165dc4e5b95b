"""What a vehicle senses at the start of a control step, in compiled calls for Python."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.scene import Buffers
from seamark.sim.engine.perception import Senses, perceive_with
from seamark.sim.engine.sight import Sight, look
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.lent import Lent, taken
from seamark.sim.physics.pose import read_pose
from seamark.sim.trackers.template.level_buffers import Bench

NOT_FINITE = -1
TRACKED, SEEN = 1, 2  # bits of what `sense` returns


class Looking(NamedTuple):
    """What a vehicle looks for its target with."""

    sight: Sight
    motion: Array  # (12,) pose and velocities in the image, written
    blurred: bool  # whether the velocities count
    buffers: Buffers
    canvas: NDArray[np.uint8]  # (H, W), drawn over
    bench: Bench  # of the tracker


@njit(cache=True, error_model="numpy")
def measure(
    lent: Lent[Senses], step: int, t: float, ok: bool, contact_n: float, row: Array
) -> bool:
    """Perceive a control step as `perceive_with`."""
    return perceive_with(taken(lent), step, t, ok, contact_n, row)


@njit(cache=True, error_model="numpy")
def sense(
    lent: Lent[Senses],
    lent_eye: Lent[Looking],
    step: int,
    frame: int,
    t: float,
    contact_n: float,
    row: Array,
) -> int:
    """Read the pose, look for the target and perceive a control step as `perceive_with`.

    Returns `NOT_FINITE` if the vehicle's state is not, else whether the tracker has the target in
    this image, and in the one that has arrived.
    """
    senses, eye = taken(lent), taken(lent_eye)
    state, pose = senses.moving.state, senses.moving.pose
    if not read_pose(state, pose):
        return NOT_FINITE
    for i in range(6):
        eye.motion[i] = pose[i]
        eye.motion[6 + i] = state[7 + i] if eye.blurred else 0.0
    corners = senses.tracked.corners
    ok = look(eye.sight, eye.motion, frame, eye.buffers, eye.canvas, eye.bench, corners)
    seen = perceive_with(senses, step, t, ok, contact_n, row)
    return (TRACKED if ok else 0) + (SEEN if seen else 0)
