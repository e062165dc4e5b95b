"""Decoding of a program's answers: finite, bounded and of the right size, or refused.

Only a tracker may answer with numbers that are out of range: they mean that it diverged and has
lost its target, like no corners at all.
"""

import struct
from collections.abc import Sequence
from enum import Enum
from itertools import chain
from math import isfinite
from typing import Any, NamedTuple

from seamark.sandbox.languages.inside.wire import (
    CORNERS,
    COUNT,
    DETECTION,
    HEADER,
    MAX_DETECTIONS,
    MAX_LABEL_BYTES,
    MAX_VALUE,
    command_limits,
)
from seamark.sandbox.protocol.messages import MessageInvalid

Command = tuple[float, ...]
FOUR = command_limits({})
Point = tuple[float, float]
Corners = tuple[Point, Point, Point, Point]


class Loss(Enum):
    """Why there are no corners."""

    REPORTED = "the tracker reports that it lost the target"
    OUT_OF_RANGE = "a coordinate is not finite or beyond MAX_VALUE"


class Detection(NamedTuple):
    """One object that a detector found."""

    label: str  # printable, not empty
    corners: Corners  # [px]
    confidence: float  # 0 to 1


def command(data: bytes | memoryview, limits: Sequence[float] = FOUR) -> Command:
    """Return surge, sway, heave [m/s], yaw rate [rad/s] and the speeds of the arm's joints.

    Raises
    ------
    MessageInvalid
        They are none, or beyond their limits.
    """
    if len(data) != HEADER.size + 8 * len(limits):
        raise MessageInvalid(f"The program answered with {len(data)} bytes.")
    numbers: Command = struct.unpack_from(f"<{len(limits)}d", data, HEADER.size)
    for number, most in zip(numbers, limits, strict=True):
        if (
            not -most <= number <= most
        ):  # NaN compares false, so that it does not get through either
            raise MessageInvalid("The program answered with a number that is out of range.")
    return numbers


def track(data: bytes | memoryview) -> Corners | Loss:
    """Return the target's corners [px], or why there are none."""
    body = data[HEADER.size :]
    if not body:
        return Loss.REPORTED
    if len(body) != CORNERS.size:
        raise MessageInvalid(f"The tracker answered with {len(body)} bytes, not 8 numbers or none.")
    numbers = CORNERS.unpack(body)
    return _points(numbers) if _in_range(numbers) else Loss.OUT_OF_RANGE


def detections(data: bytes | memoryview) -> list[Detection]:
    """Return what a detector found, in its own order."""
    body = bytes(data[HEADER.size :])
    try:
        (count,) = COUNT.unpack_from(body)
        if count > MAX_DETECTIONS:
            raise MessageInvalid(
                f"The detector answered with {count} detections; the limit is {MAX_DETECTIONS}."
            )
        decoded, offset = [], COUNT.size
        for _ in range(count):
            *numbers, length = DETECTION.unpack_from(body, offset)
            offset += DETECTION.size
            decoded.append(_detection(body[offset : offset + length], numbers, length))
            offset += length
    except struct.error:
        raise MessageInvalid("The detector's answer ends in the middle of a detection.") from None
    if offset != len(body):
        raise MessageInvalid("The detector's answer is longer than its detections.")
    return decoded


def _detection(label: bytes, numbers: Sequence[float], length: int) -> Detection:
    text = _text(label) if len(label) == length else ""
    if not 0 < length <= MAX_LABEL_BYTES or not text:
        raise MessageInvalid(
            f"The label of a detection is not printable text of 1 to {MAX_LABEL_BYTES} bytes in "
            "UTF-8."
        )
    *corners, confidence = numbers
    if not 0.0 <= confidence <= 1.0:
        raise MessageInvalid(f"The confidence of a detection is {confidence}, not within 0 and 1.")
    return Detection(text, _corners(corners), confidence)


def _text(data: bytes) -> str:
    """Return printable text in UTF-8; empty if it is none."""
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        return ""
    return text if text.isprintable() else ""


def _corners(numbers: Sequence[float]) -> Corners:
    if not _in_range(numbers):
        raise MessageInvalid("The program answered with a corner that is out of range.")
    return _points(numbers)


def _in_range(numbers: Sequence[float]) -> bool:
    """Return whether all numbers are finite and not beyond the limit; nan is not."""
    return all(-MAX_VALUE <= number <= MAX_VALUE for number in numbers)


def _points(numbers: Sequence[float]) -> Corners:
    x0, y0, x1, y1, x2, y2, x3, y3 = numbers
    return (x0, y0), (x1, y1), (x2, y2), (x3, y3)


def packed_corners(corners: Any) -> bytes:
    """Return four corners [px] in the format of a message.

    Parameters
    ----------
    corners : (4, 2) [px]
        Nested sequences or an array; our own numbers: a wrong one is our mistake, a ValueError.
    """
    numbers = [float(number) for number in chain.from_iterable(corners)]
    if len(numbers) != 8 or not all(map(isfinite, numbers)):
        raise ValueError(f"corners are four points of two finite numbers, not {corners}")
    return CORNERS.pack(*numbers)
