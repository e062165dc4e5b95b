"""Conversion between the plant's state and a pose (x, y, z, roll, pitch, yaw) [m, rad]."""

import math

from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import asin, atan2, sincos


@njit(cache=True, error_model="numpy")
def write_pose(pose: Array, state: Array) -> None:
    """Write (x, y, z, roll, pitch, yaw) as position and quaternion to `state`."""
    state[0], state[1], state[2] = pose[0], pose[1], pose[2]
    sr, cr = sincos(0.5 * pose[3])
    sp, cp = sincos(0.5 * pose[4])
    sy, cy = sincos(0.5 * pose[5])
    state[3] = cr * cp * cy + sr * sp * sy
    state[4] = sr * cp * cy - cr * sp * sy
    state[5] = cr * sp * cy + sr * cp * sy
    state[6] = cr * cp * sy - sr * sp * cy


@njit(cache=True, error_model="numpy")
def read_pose(state: Array, out: Array) -> bool:
    """Write (x, y, z, roll, pitch, yaw) of `state` to `out`; pitch is within ±pi/2.

    Returns whether they and the velocities are finite.
    """
    w, x, y, z = state[3], state[4], state[5], state[6]
    out[0], out[1], out[2] = state[0], state[1], state[2]
    out[3] = atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    out[4] = asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))
    out[5] = atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    for i in range(6):
        if not (math.isfinite(out[i]) and math.isfinite(state[7 + i])):
            return False
    return True
