"""What a detector answered to one image and what it missed, from the row of the telemetry."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seamark.sim.metrics.detection import COUNTS, FALSE_ALARM, FIRST_DECOY, HIT, IGNORED_ANSWER
from seamark.sim.metrics.recognition import BACKGROUND
from seamark.sim.recording.telemetry import ANSWER, OBJECT, answers_of, detections, objects_of
from seamark.sim.vehicles.patterns import CLASSES, DECOYS

OUTCOMES = {HIT: "hit", FALSE_ALARM: "false alarm", IGNORED_ANSWER: "ignored"}
CORNERS = tuple(f"{axis}{corner}" for corner in range(4) for axis in "xy")
_LABELS = tuple(CLASSES)
Row = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Answer:
    """One answer of a detector."""

    label: str  # of CLASSES
    confidence: float
    corners: Row  # (4, 2) [px]
    outcome: str  # of OUTCOMES


@dataclass(frozen=True, slots=True)
class Missed:
    """An object that counts and that no answer hit."""

    label: str  # of CLASSES
    corners: Row  # (4, 2) [px], true ones


def answered(row: Row) -> Iterator[Answer]:
    """Yield the answers to an image, most confident first."""
    for columns in answers_of(detections(row)):
        outcome = OUTCOMES.get(float(columns[ANSWER["outcome"]]))
        if outcome is not None:
            label = _LABELS[int(columns[ANSWER["label"]])]
            confidence = float(columns[ANSWER["confidence"]])
            yield Answer(label, confidence, corners_of(columns, ANSWER), outcome)


def missed(row: Row) -> Iterator[Missed]:
    """Yield the objects of an image that count and were not hit."""
    hit = {answer.label for answer in answered(row) if answer.outcome == OUTCOMES[HIT]}
    for label, columns in zip(_LABELS, objects_of(detections(row)), strict=True):
        if columns[OBJECT["state"]] == COUNTS and label not in hit:
            yield Missed(label, corners_of(columns, OBJECT))


def lies_on(number: float) -> str:
    """Return the title of what an answer lies on, given the number in the telemetry."""
    if number < 0.0:
        return BACKGROUND
    is_decoy = number >= FIRST_DECOY
    titles = tuple((DECOYS if is_decoy else CLASSES).values())
    return titles[int(number) - is_decoy * FIRST_DECOY]


def corners_of(columns: Row, index: dict[str, int]) -> Row:
    """Return the corners (4, 2) [px] among the columns of an object or answer."""
    corners: Row = columns[[index[name] for name in CORNERS]].reshape(4, 2)
    return corners
