"""An arm as standard messages: its joints, the force at its wrist, and where its links are.

The links keep the axes of the arm's file; the first ones hang on the vehicle's `base_link_frd`.
What the arm works on is placed in the world, with the axes of its file as well.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from seamark.formats.recording import Recording
from seamark.formats.ros import frames, geometry
from seamark.formats.ros.geometry import Message, Stamp
from seamark.sim import registry
from seamark.sim.recording.telemetry import ARM_INDEX, INDEX, WORK_INDEX, Rows, has_work
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage import Linkage, LinkData
from seamark.sim.vehicles.model import Place

TOPICS = {
    "/joint_states": "sensor_msgs/msg/JointState",
    "/arm/wrench": "geometry_msgs/msg/WrenchStamped",
}
MOUNT, SENSOR, TOOL, WORKPIECE = "arm/mount", "arm/force_sensor", "arm/tool", "workpiece"
_COLUMNS = {"position": "joint_0", "velocity": "joint_speed_0", "effort": "joint_effort_0"}
_WRENCH = ARM_INDEX["wrist_fx"]
_WORK = WORK_INDEX["workpiece_x"]
Quaternion = tuple[float, float, float, float]  # x, y, z, w


class Arm:
    """Makes the messages of an arm."""

    def __init__(self, arm: Linkage, config: Any) -> None:
        """Take an arm, and the configuration of a run, whose vehicles say where they have it."""
        self._arm, self._config = arm, config
        self._motors = arm.motors()

    def messages(self, row: Rows, stamp: Stamp) -> Iterator[tuple[str, Message]]:
        """Yield topic and message of a row."""
        count = len(self._motors)
        joints = {
            field: row[ARM_INDEX[first] : ARM_INDEX[first] + count].tolist()
            for field, first in _COLUMNS.items()
        }
        header = geometry.header(stamp, frames.BASE_FRD)
        yield "/joint_states", {"header": header, "name": list(self._motors), **joints}
        force, torque = np.split(row[_WRENCH : _WRENCH + 6], 2)
        wrench = {"force": geometry.xyz(force.tolist()), "torque": geometry.xyz(torque.tolist())}
        yield "/arm/wrench", {"header": geometry.header(stamp, SENSOR), "wrench": wrench}
        moved = [
            self._transform(link, coordinate, stamp)
            for link in self._arm.links
            if (coordinate := self._coordinate(link, joints["position"])) is not None
        ]
        vehicle = self._config.for_trial(int(row[INDEX["trial"]])).vehicle
        mount = load(vehicle).mounts[self._arm.name]
        yield "/tf", {"transforms": [_placed(frames.BASE_FRD, MOUNT, stamp, mount), *moved]}
        if has_work(len(row)):
            position, attitude = np.split(row[_WORK : _WORK + 6], 2)
            at = position.tolist(), _quaternion(*attitude.tolist())
            yield "/tf", {"transforms": [geometry.transform(frames.MAP_NED, WORKPIECE, stamp, *at)]}

    def static_transforms(self, stamp: Stamp) -> list[Message]:
        """Return where those parts are that do not move."""
        fixed = [
            self._transform(link, 0.0, stamp)
            for link in self._arm.links
            if self._coordinate(link, [0.0] * len(self._motors)) is None
        ]
        spots = ((SENSOR, self._arm.force_sensor), (TOOL, self._arm.tool))
        return fixed + [
            _placed(_name(spot.link), name, stamp, spot.place) for name, spot in spots if spot
        ]

    def _coordinate(self, link: LinkData, joints: list[float]) -> float | None:
        """Return the coordinate of a link's joint; None if it does not move."""
        leader, ratio = link.joint.follows or (link.name, 1.0)
        return ratio * joints[self._motors.index(leader)] if leader in self._motors else None

    def _transform(self, link: LinkData, coordinate: float, stamp: Stamp) -> Message:
        joint = link.joint
        parent = MOUNT if link.parent is None else _name(link.parent)
        shift, turn = np.zeros(3), (0.0, 0.0, 0.0, 1.0)
        if joint.kind == "prismatic":
            shift = coordinate * np.array(joint.axis)
        elif joint.kind == "revolute":
            sine = np.sin(0.5 * coordinate) * np.array(joint.axis)
            x, y, z = sine.tolist()
            turn = (x, y, z, float(np.cos(0.5 * coordinate)))
        return _placed(parent, _name(link.name), stamp, joint.place, shift, turn)


def arm_of(recording: Recording) -> Arm | None:
    """Return the arm of a run, if its vehicle has one."""
    config: Any = registry.benchmark(recording.benchmark).restore(dict(recording.config))
    chosen = getattr(config, "chosen_arm", lambda: None)()
    return None if chosen is None else Arm(chosen, config)


def _name(link: str) -> str:
    return f"arm/{link.replace(' ', '_')}"


def _placed(
    parent: str,
    child: str,
    stamp: Stamp,
    place: Place,
    shift: frames.Array | None = None,
    turn: Quaternion = (0.0, 0.0, 0.0, 1.0),
) -> Message:
    """Return a place in a parent's axes, and a shift and a turn from there on."""
    roll, pitch, yaw = place.turn.value
    first = _quaternion(roll, pitch, yaw)
    position = np.array(place.point.value)
    if shift is not None:
        position = position + _rotated(first, shift)
    return geometry.transform(parent, child, stamp, position.tolist(), _times(first, turn))


def _quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the turn by yaw, then pitch, then roll."""
    (sr, sp, sy), (cr, cp, cy) = (
        function(0.5 * np.array([roll, pitch, yaw])).tolist() for function in (np.sin, np.cos)
    )
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def _times(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the product: b first, then a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _rotated(turn: Quaternion, vector: frames.Array) -> frames.Array:
    x, y, z, w = turn
    axis = np.array([x, y, z])
    twice = 2.0 * np.cross(axis, vector)
    rotated: frames.Array = vector + w * twice + np.cross(axis, twice)
    return rotated
