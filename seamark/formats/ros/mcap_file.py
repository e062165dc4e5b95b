"""MCAP, with ROS 2 messages: every row, the pose of the vehicle, and camera images.

Time in the file is that of the first trial; every further trial starts a second after the end of
the one before. The column `t` starts with each trial, as everywhere.
"""

from __future__ import annotations

from typing import Any, BinaryIO

import numpy as np

from seamark.formats.recording import FRAMES, Recording
from seamark.formats.ros import frames, images, layout, schemas
from seamark.sim.recording.telemetry import INDEX, Rows

PAUSE_NS = 1_000_000_000  # between two trials
TOPICS = {
    "/telemetry": schemas.TELEMETRY,
    "/vehicle/pose": "geometry_msgs/msg/PoseStamped",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/target/pose": "geometry_msgs/msg/PoseStamped",
    "/camera/image/compressed": "sensor_msgs/msg/CompressedImage",
    "/camera/camera_info": "sensor_msgs/msg/CameraInfo",
    "/camera/annotations": "foxglove_msgs/msg/ImageAnnotations",
}
_POSITION = slice(INDEX["x"], INDEX["z"] + 1)
_ANGLES = slice(INDEX["roll"], INDEX["yaw"] + 1)
_S_TO_NS = 1e9


def write(recording: Recording, file: BinaryIO) -> None:
    """Write the messages of all rows; without seeds there are neither images nor a target."""
    from mcap_ros2.writer import Writer

    writer: Any = Writer(file)
    units = {column.name: column.unit for column in recording.columns}
    writer.add_metadata("seamark", {"run": recording.description(), "frames": FRAMES})
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
        self._pictures = images.pictures_of(recording)
        registered = {
            name: writer.register_msgdef(name, schemas.definition(name, recording.columns))
            for name in sorted(set(TOPICS.values()))
        }
        self._schemas = {topic: registered[name] for topic, name in TOPICS.items()}
        self._count = 0
        self._trial = 0.0
        self._start_ns = self._last_ns = 0

    def add(self, rows: Rows) -> None:
        """Write the messages of some rows."""
        positions = frames.to_enu(rows[:, _POSITION])
        attitudes = frames.orientation(rows[:, _ANGLES])
        for row, position, attitude in zip(rows, positions, attitudes, strict=True):
            self._add_row(row, position, attitude)

    def _add_row(self, row: Rows, position: frames.Array, attitude: frames.Array) -> None:
        now = self._time_of(row)
        stamp = {"sec": now // 1_000_000_000, "nanosec": now % 1_000_000_000}
        header = {"header": {"stamp": stamp, "frame_id": frames.MAP}}
        self._write("/telemetry", header | dict(zip(self._names, row.tolist(), strict=True)))
        self._write("/vehicle/pose", images.pose(position, attitude, stamp))
        moved = images.transform(frames.MAP, frames.BASE, stamp, position, attitude)
        self._write("/tf", {"transforms": [moved]})
        if self._pictures is not None and self._count % self._pictures.every == 0:
            for topic, message in self._pictures.messages(np.ascontiguousarray(row), stamp):
                self._write(topic, message)
        self._count += 1

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
