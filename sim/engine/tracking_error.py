"""The tracker's result compared with the ground truth of the same image.

The tracker itself reports whether it has the target; independently of that, the error computed here
tells how far off its corners are.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.camera.geometry import camera_pose, diagonal_intersection, project
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import INDEX

TOP_CENTRE, BOX_CENTRE = 4, 5

_TARGET, _TRACKED, _CORNER = INDEX["target_x"], INDEX["tracked_x"], INDEX["corner_0"]
_OK, _CORNER_ERROR = INDEX["tracker_ok"], INDEX["tracker_error"]
_ERROR_X, _ERROR_Y = INDEX["error_x_px"], INDEX["error_y_px"]
_DISTANCE_PX, _DISTANCE = INDEX["distance_px"], INDEX["distance"]


class TargetView(NamedTuple):
    """What of the target and the camera the true images of the target follow from."""

    points: Array  # (6, 3) [m] four corners, centre of the top face, centre of the box
    intrinsics: Array  # (3,) [px]
    mount: Array  # (3,) [m]
    target: int  # index of the point that counts as the target's true position


@njit(cache=True, error_model="numpy")
def write_tracking_error(
    pose: Array, corners: Array, ok: bool, view: TargetView, station: Array, row: Array
) -> None:
    """Write the columns `target_x` to `distance` of a row, except `error_x` to `error_z`.

    Parameters
    ----------
    pose : (6,) or longer [m, rad]
    corners : (8,) [px]
        Where the tracker last reported the target.
    ok : bool
        Whether it reports it now.
    station : (3,) [m]
        Where the camera should be, NED.
    row : (WIDTH or more,)
        A row of telemetry.
    """
    intrinsics = view.intrinsics
    rotation, position, images = np.empty((3, 3)), np.empty(3), np.empty((6, 2))
    camera_pose(pose, view.mount, rotation, position)
    project(view.points, rotation, position, intrinsics, images)
    total = 0.0
    for i in range(8):
        error = corners[i] - images[i // 2, i % 2]
        total += error * error
        row[_CORNER + i] = corners[i]
    row[_OK], row[_CORNER_ERROR] = ok, math.sqrt(0.25 * total)
    row[_TRACKED], row[_TRACKED + 1] = diagonal_intersection(corners)
    u, v = images[view.target, 0], images[view.target, 1]
    row[_TARGET], row[_TARGET + 1] = u, v
    error_x, error_y = u - intrinsics[1], v - intrinsics[2]
    row[_ERROR_X], row[_ERROR_Y] = error_x, error_y
    row[_DISTANCE_PX] = math.sqrt(error_x * error_x + error_y * error_y)
    x, y, z = position[0] - station[0], position[1] - station[1], position[2] - station[2]
    row[_DISTANCE] = math.sqrt(x * x + y * y + z * z)
