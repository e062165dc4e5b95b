"""Trackers and detectors in a box: images are in memory that a program can only read."""

import re
import textwrap
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.shared_images import MAX_IMAGE_BYTES
from seamark.sandbox.languages.inside.wire import MAX_DETECTIONS
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict
from seamark.sandbox.protocol.answers import Loss

pytestmark = pytest.mark.host

CORNERS = np.array([[10.0, 20.0], [30.5, 20.0], [30.5, 40.0], [10.0, 40.0]])
TRACKER = """
import numpy as np

class Tracker:
    def __init__(self, config):
        self.before = None

    def start(self, image, corners):
        self.first, self.corners = image, corners

    def update(self, image):
        {update}
"""
DETECTOR = """
class Detector:
    def __init__(self, config):
        pass

    def detect(self, image):
        return {answer}
"""
SHAPES = [(240, 320), (480, 640), (480, 640, 3), (1, 1), (1024, 1365, 3)]
LOOK = """
size = int(image.sum(dtype="i8")) % 9973
return [[size, image.ndim], image.shape[:2], [image.flat[0], image.flat[-1]], [0, 0]]
"""
REMEMBER = """
digest = lambda image: -1 if image is None else int(image.sum()) % 9973
kept = [digest(self.before), digest(self.first)]
self.before = image
return [kept, [digest(image), 0], [0, 0], [0, 0]]
"""


def picture(shape: tuple[int, ...] = (240, 320), seed: int = 1) -> NDArray[np.uint8]:
    return np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8)


@pytest.fixture
def box(isolation: IsolationLevel) -> Iterator[Box]:
    with Box(limits=Limits(), isolation=isolation) as started:
        yield started


def tracking(box: Box, update: str) -> Box:
    """Return the box with a started tracker."""
    body = textwrap.indent(textwrap.dedent(update).strip(), " " * 8).strip()
    box.load(TRACKER.format(update=body).encode(), "mine.py", {}, {"role": "tracker"})
    box.start(picture(), CORNERS)
    return box


def detecting(box: Box, answer: str) -> Box:
    box.load(DETECTOR.format(answer=answer).encode(), "mine.py", {}, {"role": "detector"})
    return box


def end_of(box: Box) -> Outcome:
    with pytest.raises(ProgramEnded) as end:
        box.update(picture())
    return end.value.outcome


@pytest.mark.parametrize("shape", SHAPES)
def test_a_tracker_sees_every_pixel_of_an_image_of_any_shape(box, shape) -> None:
    image = picture(shape, seed=2)

    answer = tracking(box, LOOK).update(image)

    size = int(image.sum(dtype="i8")) % 9973
    ends = (image.flat[0], image.flat[-1])
    assert answer == ((size, image.ndim), shape[:2], ends, (0.0, 0.0))


def test_a_tracker_gets_the_corners_and_returns_them_unchanged(box) -> None:
    assert np.array_equal(tracking(box, "return self.corners").update(picture()), CORNERS)


@pytest.mark.parametrize("answer", ["self.corners.tolist()", "tuple(map(tuple, self.corners))"])
def test_corners_may_be_an_array_or_nested_sequences(box, answer) -> None:
    assert np.array_equal(tracking(box, f"return {answer}").update(picture()), CORNERS)


def test_a_tracker_that_lost_its_target_returns_none_and_continues(box) -> None:
    tracking(box, "return None if image[0, 0] else self.corners")

    assert box.update(np.full((4, 4), 1, np.uint8)) is Loss.REPORTED
    assert not isinstance(box.update(np.full((4, 4), 0, np.uint8)), Loss)
    assert box.finish().verdict is Verdict.OK


def test_the_first_and_the_previous_image_are_still_readable(box) -> None:
    tracking(box, REMEMBER)
    images = [picture((240, 320), seed) for seed in range(5)]
    sums = [int(image.sum()) % 9973 for image in images]

    kept = [box.update(image) for image in images]

    first = int(picture().sum()) % 9973
    assert [answer[0] for answer in kept] == [
        (-1, first),
        *((before, first) for before in sums[:4]),
    ]
    assert [answer[1][0] for answer in kept] == sums


def test_a_tracker_may_be_started_again(box) -> None:
    tracking(box, "return self.corners")

    box.start(picture(seed=3), CORNERS + 1.0)

    assert np.array_equal(box.update(picture()), CORNERS + 1.0)


def test_an_image_cannot_be_written_by_a_program(box) -> None:
    outcome = end_of(tracking(box, "image[0, 0] = 1"))

    assert outcome.verdict is Verdict.USER_ERROR
    assert "read-only" in outcome.sentence


@pytest.mark.parametrize("number", ["nan", "inf", "-inf", "2e6", "-1e300"])
def test_corners_out_of_range_are_a_loss_and_the_tracker_continues(box, number) -> None:
    tracking(
        box, f"return [[float('{number}'), 0]] + [[0, 0]] * 3 if image[0, 0] else self.corners"
    )

    assert box.update(np.full((4, 4), 1, np.uint8)) is Loss.OUT_OF_RANGE
    assert np.array_equal(box.update(np.full((4, 4), 0, np.uint8)), CORNERS)
    assert box.finish().verdict is Verdict.OK


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        ("7", "type int"),
        ("[]", r"shape \(0,\)"),
        ("[1, 2, 3, 4, 5, 6, 7, 8]", "no array"),
        ("np.zeros((4, 3))", r"shape \(4, 3\)"),
        ("[[1, 2], [3, 4], [5, 6], [7]]", "no array"),
        ("np.zeros((4, 2), 'U3')", "array of <U3"),
        ("np.zeros((4, 2), complex)", "array of complex128"),
        ("[[None, None]] * 4", "array of object"),
    ],
)
def test_an_answer_that_is_not_corners_is_explained_with_its_line(box, answer, says) -> None:
    outcome = end_of(tracking(box, f"return {answer}"))

    assert outcome.verdict is Verdict.PROTOCOL_ERROR
    assert re.search(says, outcome.sentence)
    assert "four corners" in outcome.sentence
    assert "update begins in line 11 of mine.py" in outcome.sentence


@pytest.mark.parametrize(
    ("source", "role", "says"),
    [
        (b"", "tracker", "has no class Tracker"),
        (b"class Tracker:\n    def update(self, image): ...", "tracker", "no method start"),
        (b"class Controller: ...", "detector", "has no class Detector"),
        (b"class Detector: ...", "detector", "no method detect"),
    ],
)
def test_the_missing_class_or_method_of_a_role_is_named(box, source, role, says) -> None:
    with pytest.raises(ProgramEnded, match=says) as end:
        box.load(source, "mine.py", {}, {"role": role})

    assert end.value.outcome.verdict is Verdict.USER_ERROR


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((240, 320), np.float32),
        np.zeros((240, 320, 4), np.uint8),
        np.zeros((2, 240, 320, 3), np.uint8),
        np.zeros((240, 320), np.uint8)[:, ::2],
        np.zeros((0, 320), np.uint8),
        np.zeros(MAX_IMAGE_BYTES + 1, np.uint8).reshape(1, -1),
    ],
)
def test_an_image_of_the_wrong_type_is_our_mistake_not_the_programs(box, image) -> None:
    tracking(box, "return None")

    with pytest.raises(ValueError, match="an image is"):
        box.update(image)


@pytest.mark.parametrize("corners", [[[1.0, 2.0]] * 3, [[1.0, 2.0]] * 3 + [[float("nan"), 0.0]]])
def test_wrong_corners_are_our_mistake_too(box, corners) -> None:
    box.load(TRACKER.format(update="return None").encode(), "a.py", {}, {"role": "tracker"})

    with pytest.raises(ValueError, match="corners are"):
        box.start(picture(), corners)


def test_a_detector_labels_its_detections(box) -> None:
    corners = tuple(map(tuple, CORNERS.tolist()))
    detecting(box, f"[('valve', {CORNERS.tolist()}, 0.75), ('hot stab \u00e9', {corners}, 1)]")

    assert box.detect(picture()) == [("valve", corners, 0.75), ("hot stab \u00e9", corners, 1.0)]


def test_a_detector_may_return_nothing_or_as_many_as_the_limit(box) -> None:
    detecting(box, f"[('a', {CORNERS.tolist()}, 0)] * int(image[0, 0])")

    assert box.detect(np.zeros((1, 1), np.uint8)) == []
    assert len(box.detect(np.full((1, 1), MAX_DETECTIONS, np.uint8))) == MAX_DETECTIONS
    with pytest.raises(ProgramEnded, match="more than 64 detections"):
        box.detect(np.full((1, 1), MAX_DETECTIONS + 1, np.uint8))


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        ("None", "type NoneType"),
        ("[1]", "label, corners, confidence"),
        ("[('', [[1, 2]] * 4, 0.5)]", "label"),
        ("[('a' * 65, [[1, 2]] * 4, 0.5)]", "label"),
        ("[('a\\nb', [[1, 2]] * 4, 0.5)]", "label"),
        ("[('a', [[1, 2]] * 3, 0.5)]", "shape"),
        ("[('a', [[1, 2]] * 4, 1.5)]", "confidence"),
        ("[('a', [[1, 2]] * 4, float('nan'))]", "confidence"),
    ],
)
def test_an_answer_that_is_not_detections_is_explained(box, answer, says) -> None:
    with pytest.raises(ProgramEnded, match=says) as end:
        detecting(box, answer).detect(picture())

    assert end.value.outcome.verdict is Verdict.PROTOCOL_ERROR


def test_a_controller_has_no_descriptor_of_images(box) -> None:
    source = (
        b"import os\nclass Controller:\n    def __init__(self, config):\n"
        b"        print([n for n in range(64) if self.there(n)])\n"
        b"    def there(self, n):\n        try:\n            return bool(os.fstat(n))\n"
        b"        except OSError:\n            return False\n"
        b"    def step(self, o):\n        return [0] * 4\n"
    )
    box.load(source, "a.py", {}, {"observation": [["t", 0]]})
    box.step([0.0])

    assert len(box.finish().output.split(b",")) == 4


def test_a_tracker_in_a_language_without_images_is_refused_with_the_reason(isolation) -> None:
    with Box("fmu", limits=Limits(), isolation=isolation) as box:
        with pytest.raises(ProgramEnded, match=r"in Python, C, .* but not in FMU") as end:
            box.load(b"", "a", {}, {"role": "tracker"})

    assert end.value.outcome.verdict is Verdict.COMPILE_ERROR
