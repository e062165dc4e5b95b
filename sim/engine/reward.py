"""The reward of one control step, from 0 to 1: the part that its row has in the benchmark's score.

DISTANCE
    1 / (1 + d / 0.25 m), d the camera's true distance from its station: what a level of currents-v1
    earns, whose points are this fraction of the root mean square of d.
TOOL
    The share of the watch circles that the tool point is in, less a little for the power: the mean
    over a level is the level's quality in currents-v2, if power and error vary independently.

With either one a control step at which the target is lost earns 0, as in the score.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.camera.geometry import camera_pose
from seamark.sim.engine.perception import thrust_column
from seamark.sim.metrics.station_keeping import SCORE_LENGTH_M
from seamark.sim.metrics.tool_point import CIRCLES_M, POWER_WEIGHT
from seamark.sim.metrics.windows import LOST_PX
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import INDEX
from seamark.sim.vehicles import Vehicle

DISTANCE, TOOL = 0, 1
_POSE, _OK, _CORNER_ERROR = INDEX["x"], INDEX["tracker_ok"], INDEX["tracker_error"]
_DISTANCE_M = INDEX["distance"]


class Goal(NamedTuple):
    """What a step is measured against."""

    kind: int  # DISTANCE or TOOL
    tool: Array  # (3,) [m] the point that counts, in the body
    station: Array  # (3,) [m] NED, where it should be
    forward: float  # [N] the most that a thruster gives
    reverse: float  # [N]
    thrusters: int


def goal(
    vehicle: Vehicle,
    station: Array,
    mount_m: tuple[float, float, float],
    tool_m: tuple[float, float] | None,
) -> Goal:
    """Return the goal of a level.

    Parameters
    ----------
    station : (6,) [m, rad]
        Pose that the vehicle should keep.
    mount_m : (3,) [m]
        Camera in the body.
    tool_m : (2,) [m], optional
        The tool in the body, forward and starboard, at the camera's height; None: the camera.
    """
    point = np.array(mount_m if tool_m is None else (*tool_m, mount_m[2]))
    rotation, position = np.empty((3, 3)), np.empty(3)
    camera_pose(station, point, rotation, position)
    forward, reverse = vehicle.curve.limits.value
    kind = DISTANCE if tool_m is None else TOOL
    return Goal(kind, point, position, forward, reverse, len(vehicle.thrusters))


@njit(cache=True, error_model="numpy")
def reward_of(row: Array, goal: Goal) -> float:
    """Return the reward of a row of telemetry."""
    # nan, the target behind the camera, counts as lost.
    if row[_OK] == 0.0 or not row[_CORNER_ERROR] <= LOST_PX:
        return 0.0
    if goal.kind == DISTANCE:
        near: float = 1.0 / (1.0 + row[_DISTANCE_M] / SCORE_LENGTH_M)
        return near
    rotation, point = np.empty((3, 3)), np.empty(3)
    camera_pose(row[_POSE : _POSE + 6], goal.tool, rotation, point)
    wanted = goal.station
    x, y, z = point[0] - wanted[0], point[1] - wanted[1], point[2] - wanted[2]
    error, circles = math.sqrt(x * x + y * y + z * z), 0
    for radius in CIRCLES_M:
        if error <= radius:
            circles += 1
    return circles / len(CIRCLES_M) * (1.0 - POWER_WEIGHT * _power_share(row, goal))


@njit(cache=True, error_model="numpy")
def _power_share(row: Array, goal: Goal) -> float:
    """Return the power relative to that of all thrusters at full thrust; see tool_point.py."""
    total = 0.0
    for i in range(goal.thrusters):
        thrust = row[thrust_column(i, row.size)]
        share = thrust / goal.forward if thrust > 0.0 else -thrust / goal.reverse
        total += share * math.sqrt(share)
    return total / goal.thrusters
