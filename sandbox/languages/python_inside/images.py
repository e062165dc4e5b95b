"""Images for a program: memory of the trusted side, mapped so that it can only be read."""

import itertools
import mmap
import os
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .values import HEADER, MOST_FIELD, AnswerInvalid

PICTURE = struct.Struct("<4I")  # offset [B], height, width [px], channels
CORNERS = struct.Struct("<8d")
COUNT = struct.Struct("<I")
DETECTION = struct.Struct("<9dH")  # corners, confidence, bytes of the label that follows
MOST_DETECTIONS = 64
MOST_LABEL_BYTES = 64

FOUR_POINTS = "four corners (x, y) in px"
THREE_THINGS = "(label, corners, confidence)"


class Images:
    """The shared memory."""

    def __init__(self, described: dict[str, int]) -> None:
        descriptor = described["descriptor"]
        self._memory = mmap.mmap(descriptor, described["bytes"], prot=mmap.PROT_READ)
        os.close(descriptor)

    def of(self, data: bytes) -> NDArray[np.uint8]:
        """Return the image of a frame, read-only, without a copy."""
        offset, height, width, channels = PICTURE.unpack_from(data, HEADER.size)
        shape = (height, width) if channels == 1 else (height, width, channels)
        flat = np.frombuffer(self._memory, np.uint8, height * width * channels, offset)
        return flat.reshape(shape)


def corners_of(data: bytes) -> NDArray[np.float64]:
    """Return the corners (4, 2) [px] that follow the image in a frame."""
    return np.frombuffer(data, "<f8", 8, HEADER.size + PICTURE.size).reshape(4, 2)


def as_track(answer: Any) -> bytes:
    """Return what `update` returned as the body of an answer; AnswerInvalid with a sentence."""
    return b"" if answer is None else CORNERS.pack(*as_corners(answer, "update returned"))


def as_corners(answer: Any, what: str) -> list[float]:
    """Return eight floats."""
    if not isinstance(answer, (np.ndarray, list, tuple)):
        raise AnswerInvalid(f"{what} a value of type {type(answer).__name__}, not {FOUR_POINTS}")
    try:
        points = answer if isinstance(answer, np.ndarray) else np.asarray(bounded(answer))
    except (TypeError, ValueError):  # no rows, or of different lengths
        raise AnswerInvalid(f"{what} points that are no array of shape (4, 2)") from None
    if points.shape != (4, 2):
        raise AnswerInvalid(f"{what} an array of shape {points.shape}, not (4, 2)")
    if points.dtype.kind not in "fiu":
        raise AnswerInvalid(f"{what} an array of {points.dtype}, not of numbers")
    numbers: list[float] = points.astype(np.float64).reshape(8).tolist()
    for number in numbers:
        if not abs(number) <= MOST_FIELD:  # also catches NaN
            raise AnswerInvalid(f"{what} a corner with the coordinate {number}")
    return numbers


def bounded(rows: Any) -> list[list[Any]]:
    """Return no more rows and columns than say what is wrong: a list may have no end."""
    return [list(itertools.islice(row, 3)) for row in itertools.islice(rows, 5)]


def as_detections(answer: Any) -> bytes:
    """Return what `detect` returned as the body of an answer; AnswerInvalid with a sentence."""
    if not isinstance(answer, (list, tuple)):
        raise AnswerInvalid(f"detect returned a value of type {type(answer).__name__}, not a list")
    found = list(itertools.islice(answer, MOST_DETECTIONS + 1))
    if len(found) > MOST_DETECTIONS:
        raise AnswerInvalid(f"detect returned more than {MOST_DETECTIONS} detections")
    return COUNT.pack(len(found)) + b"".join(map(as_detection, found))


def as_detection(one: Any) -> bytes:
    """Return one detection packed."""
    if not isinstance(one, (list, tuple)) or len(one) != 3:
        raise AnswerInvalid(f"detect returned a detection that is not {THREE_THINGS}")
    label, corners, confidence = one
    words = label.encode() if isinstance(label, str) and label.isprintable() else b""
    if not 0 < len(words) <= MOST_LABEL_BYTES:
        raise AnswerInvalid(
            f"detect returned a label that is no printable text of 1 to {MOST_LABEL_BYTES} bytes"
        )
    if not isinstance(confidence, (float, int, np.floating)) or not 0.0 <= confidence <= 1.0:
        raise AnswerInvalid("detect returned a confidence that is no number from 0 to 1")
    numbers = as_corners(corners, "detect returned")
    return DETECTION.pack(*numbers, float(confidence), len(words)) + words
