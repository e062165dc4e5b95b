"""Reads a log from an MCAP file or a ROS bag.

Messages are decoded by the definitions of ROS's own types: the definitions in the file, which a
stranger wrote, are never parsed. A message of another type is refused by its name.
"""

from __future__ import annotations

import math
import re
import struct
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import apsw
import numpy as np
from numpy.typing import NDArray
from rosbags import rosbag1, rosbag2
from rosbags.interfaces import Connection
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from seamark.mission_logs.guesses import Frame, Guesses
from seamark.mission_logs.mapping import CORNERS, QUATERNION, TRUE_CORNERS, LogMapping, factor
from seamark.mission_logs.own_mcap import TOPIC, TYPE
from seamark.mission_logs.own_mcap import read as read_own
from seamark.mission_logs.result import LogRefused
from seamark.mission_logs.samples import ROWS_MAX, Samples

ROS1_SUFFIX = ".bag"
TOPICS_SHOWN = 12
_SEQUENCE_MAX = 4 * 1024 * 1024  # elements of one message: an image of 4 MB passes by
_NS = np.float64(1e-9)
_FIELD = re.compile(r"[A-Za-z][A-Za-z0-9_]*(\[\d{1,6}\])*")
# What rosbags raises on a damaged file; it checks its own assumptions by `assert`.
_DAMAGED = (
    *(rosbag1.ReaderError, rosbag2.ReaderError, SerdeError, apsw.Error, struct.error),
    *(ArithmeticError, AssertionError, AttributeError, EOFError, LookupError, OSError),
    *(RuntimeError, TypeError, ValueError),
)
Reader: TypeAlias = rosbag1.Reader | rosbag2.Reader
Numbers: TypeAlias = Sequence[float]
Read: TypeAlias = Callable[[Any], Numbers]


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """What is read from the messages of a topic: columns of the telemetry, and how."""

    topic: str
    columns: tuple[str, ...]
    read: Read


def read(path: Path, mapping: LogMapping) -> tuple[list[Samples], Guesses]:
    """Return the values of each topic, that of the pose first, and what was guessed.

    Raises
    ------
    LogRefused
        The file is damaged, a topic is missing or has messages of a type that is not read.
    """
    with _opened(path) as (reader, decode):
        typed = {one.topic: one for one in reader.connections}
        named = any(mapping.topics.model_dump().values()) or mapping.columns
        if not named and TOPIC in typed and typed[TOPIC].msgtype == TYPE:
            messages = reader.messages([typed[TOPIC]])
            return read_own(data for _connection, _stamp, data in messages), Guesses()
        guessed = Guesses() if named else _guessed(reader, decode, typed, mapping)
        readings = _readings(mapping, guessed, typed)
        topics: list[Samples] = []
        origin: int | None = None  # the stamps since 1970 have too many digits for a float
        for topic, parts in readings.items():
            samples, stamps = _samples(reader, decode, topic, parts)
            origin = int(stamps[0]) if origin is None else origin
            topics.append(replace(samples, stamps=(stamps - origin).astype(np.float64) * _NS))
        return topics, guessed


@contextmanager
def _opened(path: Path) -> Iterator[tuple[Reader, Callable[[bytes, str], Any]]]:
    old = path.suffix == ROS1_SUFFIX
    store = get_typestore(Stores.ROS1_NOETIC if old else Stores.ROS2_HUMBLE)
    store.max_sequence_length = _SEQUENCE_MAX
    decode = store.deserialize_ros1 if old else store.deserialize_cdr
    try:
        with (rosbag1.Reader if old else rosbag2.Reader)(path) as reader:
            for one in reader.connections:
                _check_definition(store, one, old=old)
            yield reader, decode
    except _DAMAGED as error:
        reason = str(error).replace(f"{path.parent}/", "") or type(error).__name__
        raise LogRefused(f"The file cannot be read: {reason[:200].rstrip('.')}.") from None


def _check_definition(store: Typestore, one: Connection, *, old: bool) -> None:
    """Refuse a type that has the name of a ROS type but another definition."""
    if not one.digest or one.msgtype not in _TYPES:
        return
    own = store.generate_msgdef(one.msgtype)[1] if old else store.hash_rihs01(one.msgtype)
    if one.digest not in (own, "*"):
        raise LogRefused(f"{one.topic}: its {one.msgtype} is not ROS's own type of this name.")


def _guessed(
    reader: Reader,
    decode: Callable[[bytes, str], Any],
    typed: Mapping[str, Connection],
    mapping: LogMapping,
) -> Guesses:
    """Return the only topic that tells where the vehicle is; its first message names the frame."""
    kinds = {topic: one.msgtype for topic, one in typed.items() if one.msgtype in _BY_ROLE[_POSE]}
    odometry = [topic for topic, kind in kinds.items() if kind in _BY_ROLE[_VELOCITY]]
    candidates = odometry or list(kinds)
    if len(candidates) != 1:
        why = "has several topics with a pose" if candidates else "has no topic with a pose"
        raise LogRefused(
            f"The file {why}, so name the topics of the log in the mapping, such as pose and "
            f"corners below [topics]. The file has: {_listed(typed)}."
        )
    (topic,) = candidates
    topics = {_POSE: topic} | ({_VELOCITY: topic} if odometry else {})
    connections = [one for one in reader.connections if one.topic == topic]
    first = next(reader.messages(connections), None)
    named = "" if first is None else str(decode(first[2], kinds[topic]).header.frame_id)
    # REP 103: frames are east, north, up unless their name says otherwise.
    frame: Frame = "NED" if named.lower().endswith("ned") else "ENU"
    return Guesses(topics=topics, frame=None if mapping.frame else frame)


def _readings(
    mapping: LogMapping, guessed: Guesses, typed: Mapping[str, Connection]
) -> dict[str, tuple[Reading, ...]]:
    """Return topic -> what is read from it; the pose's topic first."""
    readings: list[Reading] = []
    roles = {**mapping.topics.model_dump(), **guessed.topics}
    for role in ("pose", "velocity", "corners", "true_corners"):
        if topic := roles.get(role):
            readings.extend(_of_role(role, topic, _connection(topic, typed)))
    for column, source in mapping.columns.items():
        topic, _, path = source.name.partition(":")
        _connection(topic, typed)
        readings.append(_of_field(topic, column, path, factor(column, source)))
    grouped: dict[str, tuple[Reading, ...]] = {}
    for one in readings:
        grouped[one.topic] = (*grouped.get(one.topic, ()), one)
    return grouped


def _connection(topic: str, typed: Mapping[str, Connection]) -> Connection:
    if topic not in typed:
        raise LogRefused(f"The file has no topic {topic!r}. It has: {_listed(typed)}.")
    if typed[topic].msgtype not in _TYPES:
        raise LogRefused(
            f"{topic} has messages of the type {typed[topic].msgtype}, which is not read. Use one "
            f"of {', '.join(sorted(_TYPES))}."
        )
    return typed[topic]


def _listed(typed: Mapping[str, Connection]) -> str:
    shown = [f"{topic[:60]} ({one.msgtype[:60]})" for topic, one in sorted(typed.items())]
    more = " and more" if len(shown) > TOPICS_SHOWN else ""
    return (", ".join(shown[:TOPICS_SHOWN]) or "no topic") + more


# -- messages --------------------------------------------------------------------------------------
def _pose(pose: Any) -> Numbers:
    position, turn = pose.position, pose.orientation
    return position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w


def _velocity(twist: Any) -> Numbers:
    linear, angular = twist.linear, twist.angular
    return linear.x, linear.y, linear.z, angular.x, angular.y, angular.z


def _points(polygon: Any) -> Numbers:
    flat = [value for point in polygon.points[:5] for value in (point.x, point.y)]
    return _eight(flat)


def _eight(numbers: Sequence[float]) -> Numbers:
    """Return eight numbers; nan for an empty message, which says that the target is not seen."""
    if len(numbers) not in (0, 8):
        raise LogRefused(f"A message with corners has {len(numbers)} numbers instead of 8 or none.")
    return [float(number) for number in numbers] if len(numbers) else [math.nan] * 8


_POSE, _VELOCITY = "pose", "velocity"
_CORNERS = ("corners", "true_corners")
_COLUMNS: Mapping[str, tuple[str, ...]] = {
    _POSE: ("x", "y", "z", *QUATERNION),
    _VELOCITY: ("u", "v", "w", "p", "q", "r"),
    "corners": CORNERS,
    "true_corners": TRUE_CORNERS,
}
_BY_ROLE: Mapping[str, Mapping[str, Read]] = {
    _POSE: {
        "geometry_msgs/msg/PoseStamped": lambda message: _pose(message.pose),
        "geometry_msgs/msg/PoseWithCovarianceStamped": lambda message: _pose(message.pose.pose),
        "nav_msgs/msg/Odometry": lambda message: _pose(message.pose.pose),
    },
    _VELOCITY: {
        "geometry_msgs/msg/TwistStamped": lambda message: _velocity(message.twist),
        "nav_msgs/msg/Odometry": lambda message: _velocity(message.twist.twist),
    },
} | {
    role: {
        "geometry_msgs/msg/PolygonStamped": lambda message: _points(message.polygon),
        "geometry_msgs/msg/Polygon": _points,
        "std_msgs/msg/Float64MultiArray": lambda message: _eight(message.data),
        "std_msgs/msg/Float32MultiArray": lambda message: _eight(message.data),
    }
    for role in _CORNERS
}
_FIELDS_ONLY = (  # read by the path of a field alone
    *("geometry_msgs/msg/Vector3Stamped", "geometry_msgs/msg/WrenchStamped"),
    *("std_msgs/msg/Float64", "std_msgs/msg/Float32", "std_msgs/msg/Bool", "sensor_msgs/msg/Imu"),
    *("sensor_msgs/msg/FluidPressure", "sensor_msgs/msg/Range", "geometry_msgs/msg/PointStamped"),
)
_TYPES = frozenset(name for types in _BY_ROLE.values() for name in types) | set(_FIELDS_ONLY)


def _of_role(role: str, topic: str, one: Connection) -> Iterator[Reading]:
    types = _BY_ROLE[role]
    if one.msgtype not in types:
        raise LogRefused(
            f"{topic} has messages of the type {one.msgtype}; {role} is read from "
            f"{', '.join(sorted(types))}."
        )
    yield Reading(topic=topic, columns=_COLUMNS[role], read=types[one.msgtype])


def _of_field(topic: str, column: str, path: str, scale: float) -> Reading:
    """Return the reading of one number by its path in a message, such as `data[0]`."""
    steps = path.split(".")
    if not all(map(_FIELD.fullmatch, steps)):
        raise LogRefused(
            f"{column}: name topic and field of a message, such as /depth:data or "
            f"/pose:pose.position.z, not {topic}:{path}."
        )
    names = [part for step in steps for part in re.findall(r"[A-Za-z0-9_]+", step)]

    def value(message: Any) -> Numbers:
        for name in names:
            message = message[int(name)] if name.isdecimal() else _field(message, name, path)
        return (float(message) * scale,)

    return Reading(topic=topic, columns=(column,), read=value)


def _field(message: Any, name: str, path: str) -> Any:
    if name not in getattr(message, "__dataclass_fields__", {}):
        raise LogRefused(f"A message has no field {path}.")
    return getattr(message, name)


# -- reading ---------------------------------------------------------------------------------------
def _samples(
    reader: Reader,
    decode: Callable[[bytes, str], Any],
    topic: str,
    parts: Sequence[Reading],
) -> tuple[Samples, NDArray[np.int64]]:
    """Return the values of a topic without stamps, and the stamps [ns]."""
    connections = [one for one in reader.connections if one.topic == topic]
    columns = {name: array("d") for part in parts for name in part.columns}
    stamps, numbers = array("q"), array("q")
    for number, (one, received, data) in enumerate(reader.messages(connections), start=1):
        if number > ROWS_MAX:
            raise LogRefused(f"{topic} has more than {ROWS_MAX} messages. Cut the log into parts.")
        message = decode(data, one.msgtype)
        for part in parts:
            for name, value in zip(part.columns, part.read(message), strict=True):
                columns[name].append(value)
        stamps.append(_stamp(message) or received)
        numbers.append(number)
    if not numbers:
        raise LogRefused(f"{topic} has no messages.")
    samples = Samples(
        label=topic,
        noun="message",
        stamps=np.empty(0),
        numbers=np.frombuffer(numbers, dtype=np.int64),
        values={name: np.frombuffer(column) for name, column in columns.items()},
    )
    return samples, np.frombuffer(stamps, dtype=np.int64)


def _stamp(message: Any) -> int:
    """Return the time in the header of a message [ns]; 0 if it has none."""
    header = getattr(message, "header", None)
    return 0 if header is None else int(header.stamp.sec) * 1_000_000_000 + header.stamp.nanosec
