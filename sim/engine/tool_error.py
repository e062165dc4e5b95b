"""The error of a tool that the vehicle carries, from the telemetry of a level."""

import numpy as np
from numba import njit

from seamark.sim.camera.geometry import camera_pose
from seamark.sim.metrics.tool_point import TOOL_AHEAD_M
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import INDEX, Rows

_POSE = slice(INDEX["x"], INDEX["yaw"] + 1)


def tool_errors(rows: Rows, station: Array, mount_m: tuple[float, float, float]) -> list[float]:
    """Return the distance of the tool point from where it should be, (k,) [m].

    Parameters
    ----------
    rows : (k, WIDTH or more)
        Telemetry.
    station : (6,) [m, rad]
        Pose that the vehicle should keep.
    mount_m : (3,) [m]
        Camera in the body frame.
    """
    x, y, z = mount_m
    tool = np.array([x + TOOL_AHEAD_M, y, z])
    dx, dy, dz = (_positions(rows[:, _POSE].copy(), tool) - _positions(station[None], tool)).T
    errors: list[float] = np.sqrt(dx * dx + dy * dy + dz * dz).tolist()
    return errors


@njit(cache=True, error_model="numpy")
def _positions(poses: Array, point: Array) -> Array:
    """Return the position, (k, 3) [m] NED, of a point (3,) [m] of the body at poses (k, 6)."""
    rotation, out = np.empty((3, 3)), np.empty((poses.shape[0], 3))
    for i in range(poses.shape[0]):
        camera_pose(poses[i], point, rotation, out[i])
    return out
