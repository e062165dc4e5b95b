"""Rows of a detector from images that a test describes."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.metrics.detection import Object, match
from seamark.sim.recording.telemetry import Rows, detections, width_for
from seamark.sim.vehicles.patterns import CLASSES, DECOYS

SIZE = (400, 300)
NOWHERE = np.full((4, 2), np.nan)


class Answered(NamedTuple):
    """An answer of a detector."""

    label: str
    corners: Any
    confidence: float = 0.5


class Image(NamedTuple):
    """What is in an image by name, and the answers to it."""

    objects: Mapping[str, Object]
    answers: Sequence[Answered]
    decoys: Mapping[str, NDArray[np.float64]] = {}


def rectangle(left: float, top: float, width: float, height: float) -> NDArray[np.float64]:
    """Return the corners of an upright rectangle, clockwise from the left top."""
    right, bottom = left + width, top + height
    return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])


def seen(
    corners: NDArray[np.float64],
    uncovered: float = 1.0,
    *,
    distance: float = 1.5,
    angle: float = 0.1,
) -> Object:
    """Return an object."""
    return Object(corners, uncovered, distance, angle)


def rows_of(images: Sequence[Image]) -> Rows:
    """Return the rows of a level with these images."""
    rows = np.zeros((len(images), width_for(0, detections=True)))
    for row, image in zip(rows, images, strict=True):
        objects = [image.objects.get(name, seen(NOWHERE)) for name in CLASSES]
        decoys = [image.decoys.get(name, NOWHERE) for name in DECOYS]
        detections(row)[:] = match(objects, decoys, image.answers, SIZE).columns
    return rows
