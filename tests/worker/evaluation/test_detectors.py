"""Detectors over a box, as the simulator sees them."""

import numpy as np
import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages.inside.wire import MAX_DETECTIONS
from seamark.sandbox.languages.language import ALL_ROLES
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, Verdict
from seamark.sandbox.protocol.answers import Detection
from seamark.sim.vehicles.patterns import CLASSES
from seamark.worker.evaluation.program_adapters import ADAPTERS, DetectorAdapter
from tests.worker.evaluation.fakes import FakeBox

IMAGE = np.zeros((24, 32), np.uint8)
CORNERS = ((1.0, 2.0), (3.0, 2.0), (3.0, 4.0), (1.0, 4.0))
PROGRAM = """
class Detector:
    def __init__(self, config):
        self.labels = config["labels"]

    def detect(self, image):
        return [(label, [[1, 2], [3, 2], [3, 4], [1, 4]], 0.5) for label in self.labels]
"""


class Answering(FakeBox):
    """A box whose detector gives labels of a list, one list for each image, over and over."""

    def __init__(self, *labels: list[str]) -> None:
        super().__init__()
        self._labels = labels

    def detect(self, image: object) -> list[Detection]:
        self.steps += 1
        labels = self._labels[(self.steps - 1) % len(self._labels)]
        return [Detection(label, CORNERS, 0.5) for label in labels]


def asked(times: int, *labels: list[str]) -> DetectorAdapter:
    detector = DetectorAdapter(Answering(*labels))
    for _ in range(times):
        detector.detect(IMAGE)
    return detector


def test_each_role_has_an_adapter() -> None:
    assert set(ADAPTERS) == set(ALL_ROLES)


def test_detections_are_passed_on_as_they_are_and_classes_need_no_note() -> None:
    detector = DetectorAdapter(Answering([*CLASSES]))

    assert detector.detect(IMAGE) == [Detection(label, CORNERS, 0.5) for label in CLASSES]
    assert detector.note() == ""


def test_labels_that_are_no_class_are_passed_on_and_the_note_counts_their_answers() -> None:
    detector = DetectorAdapter(Answering(["box", "Box", "valve"], ["anode"], ["valve", "valve"]))

    labels = [[one.label for one in detector.detect(IMAGE)] for _ in range(7)]

    assert labels[:3] == [["box", "Box", "valve"], ["anode"], ["valve", "valve"]]
    assert detector.note() == (
        "[5 of 7 answers of detect() have labels that are no class: Box, valve. They are left out "
        f"of the score. The classes are {', '.join(CLASSES)}.]\n"
    )


def test_the_note_stays_short_whatever_the_labels() -> None:
    endless = [[f"{k}{j}".ljust(64, "x") for j in range(MAX_DETECTIONS)] for k in range(100)]

    note = asked(100, *endless).note()

    assert len(note) < 400
    assert note.startswith("[100 of 100 answers")
    assert "00xxxxxxxxxxxxxxxxx\N{HORIZONTAL ELLIPSIS}, 01" in note
    assert ", others. They" in note


def test_the_note_names_five_labels_without_others() -> None:
    note = asked(1, ["a", "b", "c", "d", "e"]).note()

    assert "no class: a, b, c, d, e. They" in note


@pytest.mark.host
def test_a_detector_in_a_box_answers_through_its_adapter(isolation: IsolationLevel) -> None:
    labels = ["pipe", "dolphin"]
    with Box(limits=Limits(), isolation=isolation) as box:
        box.load(PROGRAM.encode(), "mine.py", {"labels": labels}, {"role": "detector"})
        detector = ADAPTERS["detector"](box)

        assert detector.detect(IMAGE) == [Detection(label, CORNERS, 0.5) for label in labels]
        assert "no class: dolphin." in detector.note()


@pytest.mark.host
def test_what_is_no_detection_ends_the_program(isolation: IsolationLevel) -> None:
    with Box(limits=Limits(), isolation=isolation) as box:
        box.load(PROGRAM.encode(), "mine.py", {"labels": [""]}, {"role": "detector"})
        with pytest.raises(ProgramEnded, match="a label that is no printable text") as end:
            DetectorAdapter(box).detect(IMAGE)

    assert end.value.outcome.verdict is Verdict.PROTOCOL_ERROR
