"""What a program answered, read from its frame: finite, bounded, of the right size, or refused."""

import struct
from collections.abc import Sequence
from itertools import chain
from math import isfinite
from typing import Any, NamedTuple

from seamark.sandbox.protocol import messages
from seamark.sandbox.protocol.messages import FrameInvalid

Command = tuple[float, float, float, float]
Point = tuple[float, float]
Corners = tuple[Point, Point, Point, Point]

MOST_FIELD = 1e6  # [m/s, rad/s, px] a number beyond is a mistake, not a wish
CORNERS = struct.Struct("<8d")
COUNT = struct.Struct("<I")
DETECTION = struct.Struct("<9dH")  # corners, confidence, bytes of the label that follows
MOST_DETECTIONS = 64
MOST_LABEL_BYTES = 64


class Detection(NamedTuple):
    """One thing that a detector saw."""

    label: str  # printable, not empty
    corners: Corners  # [px]
    confidence: float  # 0 to 1


def command(data: bytes | memoryview) -> Command:
    """Return surge, sway, heave [m/s] and yaw rate [rad/s]; FrameInvalid if they are none."""
    if len(data) != messages.COMMAND.size:
        raise FrameInvalid(f"The program answered with {len(data)} bytes.")
    _, _, _, surge, sway, heave, yaw = messages.COMMAND.unpack(data)
    most = MOST_FIELD  # NaN compares false, so that it does not get through either
    if not (
        -most <= surge <= most
        and -most <= sway <= most
        and -most <= heave <= most
        and -most <= yaw <= most
    ):
        raise FrameInvalid("The program answered with a number beyond all limits.")
    return surge, sway, heave, yaw


def track(data: bytes | memoryview) -> Corners | None:
    """Return the target's corners [px]; None if the tracker has lost it."""
    body = data[messages.HEADER.size :]
    if not body:
        return None
    if len(body) != CORNERS.size:
        raise FrameInvalid(f"The tracker answered with {len(body)} bytes, not 8 numbers or none.")
    return _corners(CORNERS.unpack(body))


def detections(data: bytes | memoryview) -> list[Detection]:
    """Return what a detector saw, in its own order."""
    body = bytes(data[messages.HEADER.size :])
    try:
        (count,) = COUNT.unpack_from(body)
        if count > MOST_DETECTIONS:
            raise FrameInvalid(
                f"The detector answered with {count} detections; the limit is {MOST_DETECTIONS}."
            )
        found, at = [], COUNT.size
        for _ in range(count):
            *numbers, length = DETECTION.unpack_from(body, at)
            at += DETECTION.size
            found.append(_detection(body[at : at + length], numbers, length))
            at += length
    except struct.error:
        raise FrameInvalid("The detector's answer ends in the middle of a detection.") from None
    if at != len(body):
        raise FrameInvalid("The detector's answer is longer than its detections.")
    return found


def _detection(label: bytes, numbers: Sequence[float], length: int) -> Detection:
    text = label.decode("utf-8", "replace")
    if len(label) != length or not 0 < length <= MOST_LABEL_BYTES or not text.isprintable():
        raise FrameInvalid(
            f"A detection's label is no printable text of 1 to {MOST_LABEL_BYTES} bytes."
        )
    *corners, confidence = numbers
    if not 0.0 <= confidence <= 1.0:
        raise FrameInvalid(f"A detection's confidence is {confidence}, not within 0 and 1.")
    return Detection(text, _corners(corners), confidence)


def _corners(numbers: Sequence[float]) -> Corners:
    if not all(-MOST_FIELD <= number <= MOST_FIELD for number in numbers):
        raise FrameInvalid("The program answered with a corner beyond all limits.")
    x0, y0, x1, y1, x2, y2, x3, y3 = numbers
    return (x0, y0), (x1, y1), (x2, y2), (x3, y3)


def packed_corners(corners: Any) -> bytes:
    """Return four corners [px] as the frames have them.

    Parameters
    ----------
    corners : (4, 2) [px]
        Nested sequences or an array; our own numbers: a wrong one is our mistake, a ValueError.
    """
    numbers = [float(number) for number in chain.from_iterable(corners)]
    if len(numbers) != 8 or not all(map(isfinite, numbers)):
        raise ValueError(f"corners are four points of two finite numbers, not {corners}")
    return CORNERS.pack(*numbers)
