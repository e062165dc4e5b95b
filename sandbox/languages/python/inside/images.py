"""Images for the user's program: the simulator's memory, mapped read-only."""

import itertools
import mmap
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...inside.wire import (
    CORNERS,
    COUNT,
    DETECTION,
    IMAGE,
    MAX_DETECTIONS,
    MAX_LABEL_BYTES,
    MAX_VALUE,
)
from .values import AnswerInvalid

FOUR_POINTS = "four corners (x, y) in px"
TRIPLE = "(label, corners, confidence)"


class Images:
    """The shared memory."""

    def __init__(self, description: dict[str, int]) -> None:
        descriptor = description["descriptor"]
        self._memory = mmap.mmap(descriptor, description["bytes"], prot=mmap.PROT_READ)
        os.close(descriptor)

    def image(self, body: bytes, at: int = 0) -> NDArray[np.uint8]:
        """Return the image that a message has at some byte, read-only, without a copy."""
        offset, height, width, channels = IMAGE.unpack_from(body, at)
        shape = (height, width) if channels == 1 else (height, width, channels)
        flat = np.frombuffer(self._memory, np.uint8, height * width * channels, offset)
        return flat.reshape(shape)


def start_corners(body: bytes) -> NDArray[np.float64]:
    """Return the corners (4, 2) [px] that follow the image in a message."""
    return np.frombuffer(body, "<f8", 8, IMAGE.size).reshape(4, 2)


def as_track(answer: Any) -> bytes:
    """Return what `update` returned as the body of an answer; AnswerInvalid with a sentence.

    Corners that are out of range are no mistake: the simulator counts them as a loss.
    """
    return b"" if answer is None else CORNERS.pack(*as_corners(answer, "update returned"))


def as_corners(answer: Any, what: str) -> list[float]:
    """Return eight floats."""
    if not isinstance(answer, (np.ndarray, list, tuple)):
        raise AnswerInvalid(f"{what} a value of type {type(answer).__name__}, not {FOUR_POINTS}")
    try:
        points = answer if isinstance(answer, np.ndarray) else np.asarray(bounded(answer))
    except (TypeError, ValueError):  # not rows, or rows of different lengths
        raise AnswerInvalid(f"{what} points that are no array of shape (4, 2)") from None
    if points.shape != (4, 2):
        raise AnswerInvalid(f"{what} an array of shape {points.shape}, not (4, 2)")
    if points.dtype.kind not in "fiu":
        raise AnswerInvalid(f"{what} an array of {points.dtype}, not of numbers")
    numbers: list[float] = points.astype(np.float64).reshape(8).tolist()
    return numbers


def bounded(rows: Any) -> list[list[Any]]:
    """Return one row and column too many at most: a user-defined list may be endless."""
    return [list(itertools.islice(row, 3)) for row in itertools.islice(rows, 5)]


def as_detections(answer: Any) -> bytes:
    """Return what `detect` returned as the body of an answer; AnswerInvalid with a sentence."""
    if not isinstance(answer, (list, tuple)):
        raise AnswerInvalid(f"detect returned a value of type {type(answer).__name__}, not a list")
    listed = list(itertools.islice(answer, MAX_DETECTIONS + 1))
    if len(listed) > MAX_DETECTIONS:
        raise AnswerInvalid(f"detect returned more than {MAX_DETECTIONS} detections")
    return COUNT.pack(len(listed)) + b"".join(map(as_detection, listed))


def as_detection(one: Any) -> bytes:
    """Return one detection packed."""
    if not isinstance(one, (list, tuple)) or len(one) != 3:
        raise AnswerInvalid(f"detect returned a detection that is not {TRIPLE}")
    label, corners, confidence = one
    words = label.encode() if isinstance(label, str) and label.isprintable() else b""
    if not 0 < len(words) <= MAX_LABEL_BYTES:
        raise AnswerInvalid(
            f"detect returned a label that is no printable text of 1 to {MAX_LABEL_BYTES} bytes"
        )
    if not isinstance(confidence, (float, int, np.floating)) or not 0.0 <= confidence <= 1.0:
        raise AnswerInvalid("detect returned a confidence that is no number from 0 to 1")
    numbers = as_corners(corners, "detect returned")
    for number in numbers:
        if not abs(number) <= MAX_VALUE:  # also catches NaN
            raise AnswerInvalid(f"detect returned a corner with the coordinate {number}")
    return DETECTION.pack(*numbers, float(confidence), len(words)) + words
