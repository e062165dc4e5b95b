"""From the simulator's frames to those of ROS (REP 103).

The simulator has a world of north, east, down and a body of forward, starboard, down; ROS has a
world of east, north, up and a body of forward, port, up. Both turns swap axes and signs alone, so
that positions keep every bit.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import NDArray

MAP, BASE, CAMERA, TARGET = "map", "base_link", "camera_optical", "target"
# The simulator's own frames, as children of those of ROS; x, y, z, w.
MAP_NED, BASE_FRD = "map_ned", "base_link_frd"
NED_ORIENTATION = (sqrt(0.5), sqrt(0.5), 0.0, 0.0)  # half a turn about north-east
FRD_ORIENTATION = (1.0, 0.0, 0.0, 0.0)  # half a turn about x
# Optical frame: x to starboard (u), y aft (v), z down, in the body frame of ROS; x, y, z, w.
CAMERA_ORIENTATION = (sqrt(0.5), -sqrt(0.5), 0.0, 0.0)
Array = NDArray[np.float64]


def to_enu(position: Array) -> Array:
    """Return positions (..., 3) [m] of north, east, down as east, north, up."""
    return np.stack([position[..., 1], position[..., 0], -position[..., 2]], axis=-1)


def to_port_up(vector: Array) -> Array:
    """Return vectors (..., 3) of forward, starboard, down as forward, port, up."""
    turned: Array = vector * np.array([1.0, -1.0, -1.0])
    return turned


def orientation(angles: Array) -> Array:
    """Return the attitude in ROS's frames as unit quaternions.

    Parameters
    ----------
    angles : (..., 3) [rad]
        Roll, pitch, yaw of the simulator: the body turns by yaw, then pitch, then roll.

    Returns
    -------
    (..., 4)
        x, y, z, w. It is q(ENU <- NED) q(NED <- body) q(body <- forward, port, up), multiplied out.
    """
    sine, cosine = np.sin(0.5 * angles), np.cos(0.5 * angles)
    sr, sp, sy = np.moveaxis(sine, -1, 0)
    cr, cp, cy = np.moveaxis(cosine, -1, 0)
    w = cr * cp * cy + sr * sp * sy
    x = sr * cp * cy - cr * sp * sy
    y = cr * sp * cy + sr * cp * sy
    z = cr * cp * sy - sr * sp * cy
    return sqrt(0.5) * np.stack([x + y, x - y, w - z, w + z], axis=-1)
