"""MCAP, with ROS 2 messages: every row, the motion of the vehicle, and camera images.

Time in the file is that of the first trial; every further trial starts a second after the end of
the one before. The column `t` starts with each trial, as everywhere.
"""

from __future__ import annotations

from typing import Any, BinaryIO

import numpy as np

from seamark.formats.recording import FRAMES, Recording
from seamark.formats.ros import arm, frames, geometry, images, layout, motion, schemas
from seamark.sim.recording.telemetry import INDEX, Rows

PAUSE_NS = 1_000_000_000  # between two trials
TOPICS = {
    "/telemetry": schemas.TELEMETRY,
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/vehicle/pose": "geometry_msgs/msg/PoseStamped",
    "/vehicle/velocity": "geometry_msgs/msg/TwistStamped",
    "/vehicle/odometry": "nav_msgs/msg/Odometry",
    "/vehicle/thrust": "std_msgs/msg/Float64MultiArray",
    "/imu/data": "sensor_msgs/msg/Imu",
    "/dvl/twist": "geometry_msgs/msg/TwistWithCovarianceStamped",
    "/cmd_vel": "geometry_msgs/msg/TwistStamped",
    "/target/pose": "geometry_msgs/msg/PoseStamped",
    "/camera/image/compressed": "sensor_msgs/msg/CompressedImage",
    "/camera/camera_info": "sensor_msgs/msg/CameraInfo",
    "/camera/annotations": "foxglove_msgs/msg/ImageAnnotations",
}
_TOLD_FRAMES = (
    f"/telemetry: {FRAMES}; all other topics: map is east, north, up, base_link is forward, port, "
    "up (ROS REP 103)"
)
_S_TO_NS = 1e9
# Without it rosbag2 plays /tf_static to those alone who listen at that moment, and tf2 refuses it.
# The numbers (history: keep last, reliable, transient local) are read by every version of rosbag2.
_FOREVER = "{sec: 9223372036, nsec: 854775807}"
_LATCHED = (
    "- {history: 1, depth: 1, reliability: 1, durability: 1, liveliness: 1, "
    f"deadline: {_FOREVER}, lifespan: {_FOREVER}, liveliness_lease_duration: {_FOREVER}, "
    "avoid_ros_namespace_conventions: false}"
)


def write(recording: Recording, file: BinaryIO) -> None:
    """Write the messages of all rows; without seeds there are neither images nor a target."""
    from mcap_ros2.writer import Writer

    writer: Any = Writer(file)
    units = {column.name: column.unit for column in recording.columns}
    writer.add_metadata("seamark", {"run": recording.description(), "frames": _TOLD_FRAMES})
    writer.add_metadata("seamark units", units)
    writer.add_attachment(0, 0, layout.FILE, "application/json", layout.TEXT)
    messages = _Messages(recording, writer)
    for rows in recording.blocks():
        messages.add(rows)
    writer.finish()


class _Messages:
    """Writes rows as messages, in the order of time."""

    def __init__(self, recording: Recording, writer: Any) -> None:
        self._writer = writer
        self._names = [column.name for column in recording.columns]
        self._motion = motion.Motion(recording)
        self._pictures = images.pictures_of(recording)
        self._arm = arm.arm_of(recording)
        topics = TOPICS | (arm.TOPICS if self._arm else {})
        registered = {
            name: writer.register_msgdef(name, schemas.definition(name, recording.columns))
            for name in sorted(set(topics.values()))
        }
        self._schemas = {topic: registered[name] for topic, name in topics.items()}
        self._latch("/tf_static")
        self._count = 0
        self._trial = 0.0
        self._start_ns = self._last_ns = 0

    def _latch(self, topic: str) -> None:
        """Register a topic whose last message is kept; the writer cannot do it by itself."""
        self._writer._channel_ids[topic] = self._writer._writer.register_channel(
            topic=topic,
            message_encoding="cdr",
            schema_id=self._schemas[topic].id,
            metadata={"offered_qos_profiles": _LATCHED},
        )

    def add(self, rows: Rows) -> None:
        """Write the messages of some rows."""
        for row, moved in zip(rows, self._motion.of_rows(rows), strict=True):
            self._add_row(row, moved)

    def _add_row(self, row: Rows, moved: motion.RowMotion) -> None:
        now = self._time_of(row)
        stamp = {"sec": now // 1_000_000_000, "nanosec": now % 1_000_000_000}
        if self._count == 0:
            self._write("/tf_static", {"transforms": self._static(row, stamp)})
        header = {"header": geometry.header(stamp, frames.MAP_NED)}
        self._write("/telemetry", header | dict(zip(self._names, row.tolist(), strict=True)))
        for topic, message in self._motion.messages(moved, stamp):
            self._write(topic, message)
        for topic, message in self._arm.messages(row, stamp) if self._arm else ():
            self._write(topic, message)
        if self._pictures is not None and self._count % self._pictures.every == 0:
            for topic, message in self._pictures.messages(np.ascontiguousarray(row), stamp):
                self._write(topic, message)
        self._count += 1

    def _static(self, row: Rows, stamp: geometry.Stamp) -> list[geometry.Message]:
        mount = [] if self._pictures is None else [self._pictures.mount(row, stamp)]
        parts = self._arm.static_transforms(stamp) if self._arm else []
        return [*motion.static_transforms(stamp), *mount, *parts]

    def _time_of(self, row: Rows) -> int:
        """Return the time of a row in the file [ns]."""
        if row[INDEX["trial"]] != self._trial:
            self._trial = row[INDEX["trial"]]
            self._start_ns = self._last_ns + PAUSE_NS
        self._last_ns = self._start_ns + round(float(row[INDEX["t"]]) * _S_TO_NS)
        return self._last_ns

    def _write(self, topic: str, message: dict[str, Any]) -> None:
        now = self._last_ns
        self._writer.write_message(topic, self._schemas[topic], message, now, now, self._count)
