"""From the frames of a log to those of the telemetry: north, east, down; forward, starboard, down.

A log in ENU has its world in east, north, up and its body in forward, port, up, as ROS REP 103
says. With attitudes as roll, pitch, yaw in the order z-y-x, the conversion only changes signs, but
for the heading: yaw in NED is pi / 2 minus yaw in ENU.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np

from seamark.mission_logs.mapping import QUATERNION, TargetPose
from seamark.mission_logs.result import LogRefused
from seamark.mission_logs.samples import Values
from seamark.sim.camera.target import Target

_UNIT_TOLERANCE = 1e-2  # of the norm of a quaternion
_WORLD = (("x", "y", "z"), ("current_x", "current_y", "current_z"))
_TO_PORT_AND_UP = (  # in a body frame of ENU these have the other sign
    *("v", "w", "q", "r", "pitch", "ref_v", "ref_w", "ref_r", "dvl_v", "dvl_w"),
    *("error_y", "error_z", "force_y", "force_z", "moment_y", "moment_z"),
)


def in_telemetry_frames(
    values: Mapping[str, Values], frame: Literal["NED", "ENU"]
) -> dict[str, Values]:
    """Return the values with roll, pitch and yaw instead of a quaternion, in NED.

    Raises
    ------
    LogRefused
        A quaternion is incomplete or none.
    """
    converted = dict(values)
    quaternion = [converted.pop(name) for name in QUATERNION if name in converted]
    if quaternion:
        if len(quaternion) < len(QUATERNION):
            raise LogRefused("A quaternion needs all of qx, qy, qz and qw.")
        converted |= zip(("roll", "pitch", "yaw"), _angles(*quaternion), strict=True)
    if frame == "ENU":
        _from_enu(converted)
    return converted


def _angles(x: Values, y: Values, z: Values, w: Values) -> tuple[Values, Values, Values]:
    """Return roll, pitch, yaw [rad] of unit quaternions (Fossen 2021, section 2.2)."""
    norm = np.sqrt(x * x + y * y + z * z + w * w)
    wrong = np.abs(norm - 1.0) > _UNIT_TOLERANCE
    if wrong.any():
        at = int(wrong.argmax())
        raise LogRefused(
            f"The quaternion of control step {at + 1} has the norm {norm[at]:.3f} instead of 1."
        )
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return roll, pitch, yaw


def _from_enu(values: dict[str, Values]) -> None:
    for x, y, z in _WORLD:
        if {x, y, z} <= values.keys():
            values[x], values[y], values[z] = values[y], values[x], -values[z]
    for name in _TO_PORT_AND_UP:
        if name in values:
            values[name] = -values[name]
    if "yaw" in values:
        values["yaw"] = 0.5 * math.pi - values["yaw"]


def at_target(
    values: dict[str, Values],
    measured: TargetPose,
    frame: Literal["NED", "ENU"],
    target: Target,
) -> None:
    """Move and turn the vehicle's path in place, so that the log's target is the benchmark's."""
    north, east, down = measured.position
    heading = measured.heading
    if frame == "ENU":
        north, east, down, heading = east, north, -down, 0.5 * math.pi - heading
    turn = target.heading_rad - heading
    cos, sin = math.cos(turn), math.sin(turn)
    centre = target.top_centre().tolist()
    if {"x", "y", "z"} <= values.keys():
        off_north, off_east = values["x"] - north, values["y"] - east
        values["x"] = centre[0] + cos * off_north - sin * off_east
        values["y"] = centre[1] + sin * off_north + cos * off_east
        values["z"] = centre[2] + values["z"] - down
    if "yaw" in values:
        values["yaw"] = values["yaw"] + turn
    if {"current_x", "current_y"} <= values.keys():
        ahead, side = values["current_x"], values["current_y"]
        values["current_x"] = cos * ahead - sin * side
        values["current_y"] = sin * ahead + cos * side
