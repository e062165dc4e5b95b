"""Which moments of a detector's run teach most.

These are its most confident false alarms, the objects that it missed although they are clear to
see, and the hits that it was least sure of. Neighbouring images show nearly the same, so there is
one example at most of each class in each level of each trial, and few of each class in all.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.server.runs.showing.detections import (
    Row,
    corners_of,
    lies_on,
)
from seamark.sim.metrics.detection import COUNTS, FALSE_ALARM, HIT
from seamark.sim.recording.telemetry import (
    ANSWER,
    INDEX,
    OBJECT,
    Rows,
    answers_of,
    detections,
    objects_of,
)
from seamark.sim.vehicles.patterns import CLASSES

EXAMPLES = 8  # of each kind
OF_CLASS = 2  # most of each class among them
ALARMS, MISSES, HITS = "false_alarms", "misses", "hits"
KINDS = (ALARMS, MISSES, HITS)
Flags = NDArray[np.bool_]
Order = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Example:
    """A moment of a run, with what was answered or missed there."""

    trial: int
    level: int
    t: float  # [s]
    label: str  # of CLASSES
    corners: Row  # (4, 2) [px] of the answer, or true ones of what was missed
    confidence: float | None  # of the answer
    lies_on: str | None  # of a false alarm: class, decoy or background
    order: Order  # lower ones come first

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON."""
        return {
            "trial": self.trial,
            "level": self.level,
            "t": self.t,
            "label": self.label,
            "corners": np.round(self.corners, 1).tolist(),
            "confidence": self.confidence,
            "lies_on": self.lies_on,
        }


def of_level(rows: Rows, depth: float) -> dict[str, list[Example]]:
    """Return the best example of each kind and class in one level, whose value is `depth`."""
    found: dict[str, list[Example]] = {kind: [] for kind in KINDS}
    for number, label in enumerate(CLASSES):
        for kind, choose in ((ALARMS, _alarm), (MISSES, _missed), (HITS, _hit)):
            found[kind] += choose(rows, depth, number, label)
    return found


def best(examples: Iterable[Example]) -> list[Example]:
    """Return the first examples, with few of each class."""
    chosen: list[Example] = []
    of_class = Counter[str]()
    for example in sorted(examples, key=lambda one: (one.order, one.trial, one.level, one.label)):
        if of_class[example.label] < OF_CLASS and len(chosen) < EXAMPLES:
            of_class[example.label] += 1
            chosen.append(example)
    return chosen


def _alarm(rows: Rows, depth: float, number: int, label: str) -> Iterator[Example]:
    answer = _answer(rows, number, FALSE_ALARM, lambda confidence: -confidence)
    if answer is not None:
        row, columns = answer
        confidence = float(columns[ANSWER["confidence"]])
        on = lies_on(float(columns[ANSWER["on"]]))
        corners = corners_of(columns, ANSWER)
        yield _example(row, label, corners, (-confidence, depth), confidence, on)


def _hit(rows: Rows, depth: float, number: int, label: str) -> Iterator[Example]:
    answer = _answer(rows, number, HIT, lambda confidence: confidence)
    if answer is not None:
        row, columns = answer
        confidence = float(columns[ANSWER["confidence"]])
        yield _example(row, label, corners_of(columns, ANSWER), (confidence, depth), confidence)


def _answer(
    rows: Rows, number: int, outcome: float, order: Callable[[Row], Row]
) -> tuple[Row, Row] | None:
    """Return row and columns of the first answer of a class with an outcome; None without one."""
    answers = answers_of(detections(rows))
    images, slots = np.nonzero(
        _of_class(answers, number) & (_column(answers, "outcome") == outcome)
    )
    if not len(images):
        return None
    at = order(answers[images, slots, ANSWER["confidence"]]).argmin()
    return rows[images[at]], answers[images[at], slots[at]]


def _missed(rows: Rows, depth: float, number: int, label: str) -> Iterator[Example]:
    columns = detections(rows)
    answers, objects = answers_of(columns), objects_of(columns)[:, number]
    hit = (_of_class(answers, number) & (_column(answers, "outcome") == HIT)).any(axis=1)
    images = np.flatnonzero((objects[:, OBJECT["state"]] == COUNTS) & ~hit)
    if len(images):
        visible, distance = (objects[images, OBJECT[name]] for name in ("visible", "distance"))
        at = np.lexsort((distance, -np.round(visible, 2)))[0]
        corners = corners_of(objects[images[at]], OBJECT)
        order = (depth, -float(visible[at]), float(distance[at]))
        yield _example(rows[images[at]], label, corners, order)


def _of_class(answers: Row, number: int) -> Flags:
    return np.asarray(_column(answers, "label") == number)


def _column(answers: Row, name: str) -> Row:
    column: Row = answers[..., ANSWER[name]]
    return column


def _example(
    row: Row,
    label: str,
    corners: Row,
    order: Order,
    confidence: float | None = None,
    on: str | None = None,
) -> Example:
    trial, level, t = (float(row[INDEX[name]]) for name in ("trial", "level", "t"))
    return Example(int(trial), int(level), t, label, corners, confidence, on, order)
