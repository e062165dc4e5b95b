"""Matches a detector's answers to one image with what is in it.

The rules, in their order:

1. An answer whose label is no class counts for nothing, and neither does one that has no area in
   the image: they are counted for a note to the owner of the program (`Matched`).
2. Of the others the 16 most confident count; equally confident ones in the order of the answer.
3. Answers and truth are compared by their upright bounding boxes, clipped to the image.
4. In the order of confidence, an answer matches the object of its class if no answer before it did
   and their intersection over union is at least `HIT_IOU` (COCO: Lin et al. 2014). There is one
   object of each class, so a second answer to it is a false alarm.
5. The visible share of an object is the share of its outline that is in the image times that which
   nothing covers. An object with less than `VISIBLE`, or with less than `INSIDE` of its outline in
   the image, is ignored: an answer that matches it is neither a hit nor a false alarm. A second one
   is a false alarm, as in COCO.
6. The corner error of a hit is the root mean square over the four corners, as the answer and the
   object have them, unclipped; of the orders in which a quadrilateral can be read (from any corner,
   in either direction) the one with the smallest error counts, because a pipe has no first corner.
7. Whatever its label, an answer lies on the object or decoy with which its intersection over union
   is largest, if that is at least `ON_IOU`.
"""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import (
    ANSWER_COLUMNS,
    ANSWERS,
    DETECTION_WIDTH,
    answers_of,
    objects_of,
)
from seamark.sim.vehicles.patterns import CLASSES, DECOYS

HIT_IOU = 0.5  # S: COCO and PASCAL VOC
ON_IOU = 0.3  # E: less than a hit needs, so that a box drawn too large is no answer to nothing
VISIBLE = 0.4  # E: share of an object below which it is ignored
INSIDE = 0.6  # E: likewise of its outline in the image
ABSENT, COUNTS, IGNORED = 0.0, 1.0, 2.0  # states of an object
HIT, FALSE_ALARM, IGNORED_ANSWER = 1.0, 2.0, 3.0  # outcomes of an answer
NOTHING, FIRST_DECOY = -1.0, 100  # what an answer lies on, and its label if there is none

_LABELS = {name: index for index, name in enumerate(CLASSES)}
_NUMBERS = np.array([*range(len(CLASSES)), *(FIRST_DECOY + at for at in range(len(DECOYS)))], float)
_ORDERS = tuple(
    tuple((first + turn * step) % 4 for step in range(4)) for turn in (1, -1) for first in range(4)
)
_NO_CORNERS = [math.nan] * 8
_NO_ANSWER = (NOTHING, *(0.0,) * (len(ANSWER_COLUMNS) - 3), math.nan, NOTHING)


class Object(NamedTuple):
    """The object of one class, seen or not."""

    corners: NDArray[np.float64]  # (4, 2) [px] of its plan rectangle; nan if behind the camera
    uncovered: float  # share of it that nothing covers, in the image or not, 0 to 1
    distance: float  # [m] of the camera from its centre
    angle: float  # [rad] between the line of sight to its centre and its normal


class Answer(Protocol):
    """One answer of a detector."""

    @property
    def label(self) -> str:
        """What it is said to be."""

    @property
    def corners(self) -> ArrayLike:
        """Its corners (4, 2) [px]."""

    @property
    def confidence(self) -> float:
        """From 0 to 1."""


class Matched(NamedTuple):
    """The columns of one image, and how many answers count for nothing."""

    columns: NDArray[np.float64]  # (DETECTION_WIDTH,)
    unknown: int  # answers whose label is no class
    without_area: int  # answers of a class without area in the image, or with numbers that are none


class _Kept(NamedTuple):
    """The answers of an image that count, most confident first."""

    labels: list[int]
    confidences: list[float]
    corners: Array  # (n, 4, 2) [px]
    boxes: Array  # (n, 4) [px]


def match(
    objects: Sequence[Object],
    decoys: Sequence[ArrayLike],
    answers: Iterable[Answer],
    image_size: tuple[int, int],
) -> Matched:
    """Return the columns of an image, by the rules above.

    Parameters
    ----------
    objects
        Of each class, in the order of `CLASSES`.
    decoys
        Corners (4, 2) [px] of each decoy, in the order of `DECOYS`; nan if behind the camera.
    answers
        In the order in which the detector gave them.
    image_size
        Width and height [px]. The centre of the first pixel is (0, 0).
    """
    kept, unknown, without_area = _kept(answers, image_size)
    things = np.array([*(one.corners for one in objects), *decoys], dtype=np.float64)
    boxes = _boxes(things, image_size)
    areas = _areas(boxes)[: len(objects)].tolist()
    inside = [
        _share_inside(one.corners.tolist(), image_size) if area > 0.0 else 0.0
        for one, area in zip(objects, areas, strict=True)
    ]
    states = [_state(one, share) for one, share in zip(objects, inside, strict=True)]
    boxes[[at for at, state in enumerate(states) if state == ABSENT]] = 0.0
    columns = np.empty(DETECTION_WIDTH)
    objects_of(columns)[:] = [
        _object_row(*one) for one in zip(objects, states, inside, strict=True)
    ]
    rows, count = answers_of(columns), len(kept.labels)
    rows[count:] = _NO_ANSWER
    if count:
        rows[:count] = _answer_rows(kept, _ious(kept.boxes, boxes), states, objects)
    return Matched(columns, unknown, without_area)


def _kept(answers: Iterable[Answer], image_size: tuple[int, int]) -> tuple[_Kept, int, int]:
    """Return the answers that count, and how many have no known label and no area."""
    given = list(answers)
    known = [one for one in given if one.label in _LABELS]
    confidences = [one.confidence for one in known]
    corners = np.array([one.corners for one in known], dtype=np.float64).reshape(-1, 4, 2)
    boxes = _boxes(corners, image_size)
    finite = np.isfinite(corners).all(axis=(1, 2)) & (_areas(boxes) > 0.0)
    counting = [
        at
        for at, (confidence, counts) in enumerate(zip(confidences, finite.tolist(), strict=True))
        if counts and 0.0 <= confidence <= 1.0
    ]
    order = sorted(counting, key=lambda at: -confidences[at])[:ANSWERS]
    kept = _Kept(
        [_LABELS[known[at].label] for at in order],
        [confidences[at] for at in order],
        corners[order],
        boxes[order],
    )
    return kept, len(given) - len(known), len(known) - len(counting)


def _boxes(corners: Array, image_size: tuple[int, int]) -> Array:
    """Return left, top, right, bottom [px] of quadrilaterals (n, 4, 2), clipped, (n, 4)."""
    far = np.array(image_size) - 0.5
    least, most = corners.min(axis=1), corners.max(axis=1)
    return np.hstack([np.clip(least, -0.5, far), np.clip(most, -0.5, far)])


def _ious(first: Array, second: Array) -> Array:
    """Return the intersection over union of boxes (n, 4) that have an area and (m, 4), (n, m).

    It is 0 with a box that has no area.
    """
    one, two = first[:, None, :], second[None, :, :]
    overlap = np.minimum(one[..., 2:], two[..., 2:]) - np.maximum(one[..., :2], two[..., :2])
    common = np.where((overlap > 0.0).all(axis=-1), overlap[..., 0] * overlap[..., 1], 0.0)
    union = _areas(first)[:, None] + _areas(second)[None, :] - common
    result: Array = np.where(common > 0.0, common / union, 0.0)
    return result


def _areas(boxes: Array) -> Array:
    """Return the areas of boxes (n, 4), (n,) [px²]; nan if a corner is none."""
    result: Array = (boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1])
    return result


def _state(one: Object, inside: float) -> float:
    if inside == 0.0:
        return ABSENT
    return IGNORED if inside * one.uncovered < VISIBLE or inside < INSIDE else COUNTS


def _share_inside(corners: list[list[float]], image_size: tuple[int, int]) -> float:
    """Return which share of the area of a convex quadrilateral is in the image; 0 without one."""
    whole = _area(corners)
    polygon = corners
    for along, size in enumerate(image_size):
        polygon = _cut(polygon, along, 1.0, -0.5)
        polygon = _cut(polygon, along, -1.0, 0.5 - size)
    return _area(polygon) / whole if whole > 0.0 else 0.0


def _cut(polygon: list[list[float]], along: int, sign: float, limit: float) -> list[list[float]]:
    """Return the part of a polygon where sign * coordinate >= limit (Sutherland, Hodgman 1974)."""
    kept = []
    for point, following in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        here, there = sign * point[along] - limit, sign * following[along] - limit
        if here >= 0.0:
            kept.append(point)
        if (here >= 0.0) != (there >= 0.0):
            share = here / (here - there)
            kept.append([a + share * (b - a) for a, b in zip(point, following, strict=True)])
    return kept


def _area(polygon: list[list[float]]) -> float:
    pairs = zip(polygon, polygon[1:] + polygon[:1], strict=True)
    return 0.5 * abs(math.fsum(a[0] * b[1] - b[0] * a[1] for a, b in pairs))


def _object_row(one: Object, state: float, inside: float) -> tuple[float, ...]:
    """Return the columns of an object, of which `inside` is in the image."""
    corners = _NO_CORNERS if state == ABSENT else one.corners.ravel().tolist()
    return (state, *corners, inside * one.uncovered, one.distance, one.angle)


def _answer_rows(
    kept: _Kept, ious: Array, states: Sequence[float], objects: Sequence[Object]
) -> list[tuple[float, ...]]:
    """Return the columns of each answer.

    Parameters
    ----------
    ious : (answers, objects and decoys)
    """
    best = ious.argmax(axis=1).tolist()
    rows, taken = [], set()
    for at, (label, on) in enumerate(zip(kept.labels, best, strict=True)):
        iou, corners = float(ious[at, label]), kept.corners[at]
        outcome, error = FALSE_ALARM, math.nan
        if iou >= HIT_IOU and label not in taken:
            taken.add(label)
            outcome = HIT if states[label] == COUNTS else IGNORED_ANSWER
        if outcome == HIT:
            error = corner_error(corners.tolist(), objects[label].corners.tolist())
        lies_on = float(_NUMBERS[on]) if ious[at, on] >= ON_IOU else NOTHING
        answered = (float(label), kept.confidences[at], *corners.ravel().tolist())
        rows.append((*answered, outcome, iou, error, lies_on))
    return rows


def corner_error(answered: Sequence[Sequence[float]], true: Sequence[Sequence[float]]) -> float:
    """Return the corner error of rule 6 [px] of four corners each [px]."""
    squares = [[(x - u) * (x - u) + (y - v) * (y - v) for u, v in true] for x, y in answered]
    return min(
        math.sqrt(0.25 * (squares[0][a] + squares[1][b] + squares[2][c] + squares[3][d]))
        for a, b, c, d in _ORDERS
    )
