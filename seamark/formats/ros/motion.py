"""The vehicle's motion as standard messages: world east, north, up; body forward, port, up.

Pose, velocity and turn rates are the true ones; the DVL's are what it measured. A message whose
numbers the rows do not have is left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from seamark.formats.recording import Recording
from seamark.formats.ros import frames, geometry
from seamark.formats.ros.geometry import Message, Stamp
from seamark.sim import registry
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import INDEX, Rows

UNMEASURED = 1e6  # [rad²/s²] variance of the turn rates in the DVL's message: it measures none
_UNKNOWN_6, _UNKNOWN_3 = [0.0] * 36, [0.0] * 9  # covariances, as geometry_msgs and sensor_msgs say
_ABSENT_3 = [-1.0, *[0.0] * 8]  # of a sensor_msgs/Imu that does not measure this
_NEEDS = {"/cmd_vel": "ref_u", "/dvl/twist": "dvl_u", "/vehicle/thrust": "thrust_0"}
Vector = list[float]


class RowMotion(NamedTuple):
    """What a row says, in the frames of ROS."""

    position: Vector
    attitude: Vector
    velocity: Vector
    rates: Vector
    reference: Vector
    dvl: Vector
    reference_r: float
    thrust: Vector


class Motion:
    """Makes the messages of rows, which come in the order of time."""

    def __init__(self, recording: Recording) -> None:
        config: Any = registry.benchmark(recording.benchmark).restore(dict(recording.config))
        unused = config.unused_columns()
        self._absent = {topic for topic, column in _NEEDS.items() if column in unused}
        names = [one.name for one in recording.columns if one.name.startswith("thrust_")]
        self._thrusters = sum(name not in unused for name in names)
        sigma_m_s = float(getattr(config, "dvl_sigma_m_s", 0.0))
        variances = [sigma_m_s**2] * 3 + [UNMEASURED] * 3
        self._dvl_covariance: Vector = np.diag(variances).ravel().tolist()
        self._last_dvl = [0.0, 0.0, 0.0]  # before the first measurement

    def of_rows(self, rows: Rows) -> Iterator[RowMotion]:
        """Yield what each row says."""
        vectors = (
            frames.to_port_up(_columns(rows, first, last)).tolist()
            for first, last in (("u", "w"), ("p", "r"), ("ref_u", "ref_w"), ("dvl_u", "dvl_w"))
        )
        columns = (
            frames.to_enu(_columns(rows, "x", "z")).tolist(),
            frames.orientation(_columns(rows, "roll", "yaw")).tolist(),
            *vectors,
            (-rows[:, INDEX["ref_r"]]).tolist(),
            telemetry.thrusts(rows)[:, : self._thrusters].tolist(),
        )
        return map(RowMotion._make, zip(*columns, strict=True))

    def messages(self, row: RowMotion, stamp: Stamp) -> Iterator[tuple[str, Message]]:
        """Yield topic and message of all that the row has."""
        yield from _state(row, stamp)
        for topic, message in self._of_controller(row, stamp):
            if topic not in self._absent:
                yield topic, message

    def _of_controller(self, row: RowMotion, stamp: Stamp) -> Iterator[tuple[str, Message]]:
        header = geometry.header(stamp, frames.BASE)
        if row.dvl != self._last_dvl and _known(row.dvl):
            self._last_dvl = row.dvl
            twist = geometry.twist(row.dvl, (0.0, 0.0, 0.0))
            measured = {"twist": twist, "covariance": self._dvl_covariance}
            yield "/dvl/twist", {"header": header, "twist": measured}
        if _known(row.reference):
            turn = (0.0, 0.0, row.reference_r)
            yield "/cmd_vel", {"header": header, "twist": geometry.twist(row.reference, turn)}
        if _known(row.thrust):
            count = len(row.thrust)
            label = {"label": "thruster", "size": count, "stride": count}
            array = {"layout": {"dim": [label], "data_offset": 0}, "data": row.thrust}
            yield "/vehicle/thrust", array


def static_transforms(stamp: Stamp) -> list[Message]:
    """Return where the simulator's own frames are in those of ROS."""
    origin = (0.0, 0.0, 0.0)
    return [
        geometry.transform(frames.MAP, frames.MAP_NED, stamp, origin, frames.NED_ORIENTATION),
        geometry.transform(frames.BASE, frames.BASE_FRD, stamp, origin, frames.FRD_ORIENTATION),
    ]


def _state(row: RowMotion, stamp: Stamp) -> Iterator[tuple[str, Message]]:
    """Yield where the vehicle is and how it moves."""
    placed = _known(row.position) and _known(row.attitude)
    moves = _known(row.velocity) and _known(row.rates)
    header = geometry.header(stamp, frames.BASE)
    twist = geometry.twist(row.velocity, row.rates)
    if placed:
        yield "/vehicle/pose", geometry.pose_stamped(row.position, row.attitude, stamp)
        moved = geometry.transform(frames.MAP, frames.BASE, stamp, row.position, row.attitude)
        yield "/tf", {"transforms": [moved]}
    if moves:
        yield "/vehicle/velocity", {"header": header, "twist": twist}
    if placed and moves:
        pose = geometry.pose(row.position, row.attitude)
        yield (
            "/vehicle/odometry",
            {
                "header": geometry.header(stamp, frames.MAP),
                "child_frame_id": frames.BASE,
                "pose": {"pose": pose, "covariance": _UNKNOWN_6},
                "twist": {"twist": twist, "covariance": _UNKNOWN_6},
            },
        )
        yield (
            "/imu/data",
            {
                "header": header,
                "orientation": geometry.xyzw(row.attitude),
                "orientation_covariance": _UNKNOWN_3,
                "angular_velocity": geometry.xyz(row.rates),
                "angular_velocity_covariance": _UNKNOWN_3,
                "linear_acceleration": geometry.xyz((0.0, 0.0, 0.0)),
                "linear_acceleration_covariance": _ABSENT_3,
            },
        )


def _known(values: Vector) -> bool:
    return all(map(math.isfinite, values))


def _columns(rows: Rows, first: str, last: str) -> Rows:
    return rows[:, INDEX[first] : INDEX[last] + 1]
