"""The tracker beside ground truth: what a row of telemetry says of one picture.

"Lost" is decided by the tracker itself and, apart from it, by how far its corners are off here.
"""

import math

import numpy as np
from numba import njit

from seamark.sim.camera.geometry import look, project
from seamark.sim.recording.telemetry import INDEX
from seamark.sim.vehicles import Array

# Points (6, 3) [m] of the target: four corners, the top face's centre, the box's middle; intrinsics
# (3,) [px] and mount (3,) [m] of the camera; which of the points is the target's true place.
View = tuple[Array, Array, Array, int]
CENTRE, MIDDLE = 4, 5

_TARGET, _TRACKED, _CORNER = INDEX["target_x"], INDEX["tracked_x"], INDEX["corner_0"]
_OK, _OFF = INDEX["tracker_ok"], INDEX["tracker_error"]
_OFF_X, _OFF_Y = INDEX["error_x_px"], INDEX["error_y_px"]
_DISTANCE_PX, _DISTANCE = INDEX["distance_px"], INDEX["distance"]


@njit(cache=True, error_model="numpy")
def crossing(corners: Array) -> tuple[float, float]:
    """Return where the diagonals cross: the image of the face's centre under any perspective.

    `corners` is (8,) [px], x0 y0 to x3 y3. For corners without a proper crossing, their mean.
    """
    x0, y0, x1, y1 = corners[0], corners[1], corners[2], corners[3]
    x2, y2, x3, y3 = corners[4], corners[5], corners[6], corners[7]
    ax, ay, bx, by = x2 - x0, y2 - y0, x3 - x1, y3 - y1
    determinant = ax * by - ay * bx
    if abs(determinant) < 1e-9:
        return 0.25 * (x0 + x1 + x2 + x3), 0.25 * (y0 + y1 + y2 + y3)
    share = ((x1 - x0) * by - (y1 - y0) * bx) / determinant
    return x0 + share * ax, y0 + share * ay


@njit(cache=True, error_model="numpy")
def judge(pose: Array, corners: Array, ok: bool, view: View, station: Array, row: Array) -> None:
    """Write the columns `target_x` to `distance` to a row, but for what the program saw.

    Parameters
    ----------
    pose : (6,) or longer [m, rad]
    corners : (8,) [px]
        Where the tracker last was sure to see the target.
    ok : bool
        Whether it is now.
    station : (3,) [m]
        Where the camera should be, NED.
    row : (WIDTH,)
        Of the telemetry.
    """
    points, intrinsics, mount, target = view
    rotation, place, images = np.empty((3, 3)), np.empty(3), np.empty((6, 2))
    look(pose, mount, rotation, place)
    project(points, rotation, place, intrinsics, images)
    total = 0.0
    for i in range(8):
        off = corners[i] - images[i // 2, i % 2]
        total += off * off
        row[_CORNER + i] = corners[i]
    row[_OK], row[_OFF] = ok, math.sqrt(0.25 * total)
    row[_TRACKED], row[_TRACKED + 1] = crossing(corners)
    u, v = images[target, 0], images[target, 1]
    row[_TARGET], row[_TARGET + 1] = u, v
    off_x, off_y = u - intrinsics[1], v - intrinsics[2]
    row[_OFF_X], row[_OFF_Y] = off_x, off_y
    row[_DISTANCE_PX] = math.sqrt(off_x * off_x + off_y * off_y)
    x, y, z = place[0] - station[0], place[1] - station[1], place[2] - station[2]
    row[_DISTANCE] = math.sqrt(x * x + y * y + z * z)
