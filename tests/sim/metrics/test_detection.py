"""Answers of a detector to one image: each rule of the matching, and hostile answers."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seamark.sim.metrics.detection import (
    HIT_IOU,
    INSIDE,
    ON_IOU,
    VISIBLE,
    Matched,
    Object,
    corner_error,
    match,
)
from seamark.sim.recording.telemetry import ANSWERS, DETECTION_COLUMNS
from seamark.sim.vehicles.patterns import CLASSES, DECOYS
from tests.sim.metrics.detector_rows import NOWHERE, SIZE, Answered, rectangle, seen

AT = {column.name: index for index, column in enumerate(DETECTION_COLUMNS)}
BOX, PIPE = list(CLASSES).index("box"), list(CLASSES).index("pipe")


def matched(
    answers: Sequence[Answered],
    decoys: Sequence[tuple[str, NDArray[np.float64]]] = (),
    **objects: Object,
) -> Matched:
    """Return what an image with some objects and decoys makes of the answers."""
    return match(
        [objects.get(name, seen(NOWHERE)) for name in CLASSES],
        [dict(decoys).get(name, NOWHERE) for name in DECOYS],
        answers,
        SIZE,
    )


def column(found: Matched, name: str) -> list[float]:
    """Return a column of all slots of the answers."""
    return [float(found.columns[AT[f"answer_{slot}_{name}"]]) for slot in range(ANSWERS)]


def of_object(found: Matched, number: int, name: str) -> float:
    return float(found.columns[AT[f"object_{number}_{name}"]])


HERE = rectangle(100.0, 100.0, 60.0, 40.0)


def test_an_answer_on_its_object_is_a_hit_and_all_is_on_record() -> None:
    answer = HERE + np.array([3.0, 4.0])

    found = matched([Answered("pipe", answer, 0.7)], pipe=seen(HERE))

    overlap = 57.0 * 36.0
    assert column(found, "outcome") == [1.0] + [0.0] * 15
    assert column(found, "label") == [PIPE] + [-1.0] * 15
    assert column(found, "confidence")[0] == 0.7
    assert [column(found, name)[0] for name in ("x2", "y2")] == [163.0, 144.0]
    assert column(found, "iou")[0] == pytest.approx(overlap / (2.0 * 2400.0 - overlap), rel=1e-15)
    assert column(found, "error")[0] == 5.0
    assert math.isnan(column(found, "error")[1])
    assert column(found, "on") == [PIPE] + [-1.0] * 15
    assert [of_object(found, PIPE, name) for name in ("state", "visible", "x0", "y3")] == [
        1.0,
        1.0,
        100.0,
        140.0,
    ]
    assert [of_object(found, PIPE, name) for name in ("distance", "angle")] == [1.5, 0.1]
    assert [of_object(found, BOX, name) for name in ("state", "visible")] == [0.0, 0.0]
    assert math.isnan(of_object(found, BOX, "x0"))


def test_nothing_to_be_found_and_no_answer_leave_every_slot_empty() -> None:
    found = matched([])

    assert column(found, "label") == [-1.0] * ANSWERS
    assert column(found, "outcome") == column(found, "confidence") == [0.0] * ANSWERS
    assert column(found, "on") == [-1.0] * ANSWERS


@pytest.mark.parametrize(
    ("width", "height", "outcome"),
    [(80.0, 60.0, 1.0), (80.001, 60.0, 2.0), (40.0, 30.0, 1.0), (40.0, 29.999, 2.0)],
)
def test_an_answer_hits_from_half_of_the_union_on(
    width: float, height: float, outcome: float
) -> None:
    thing = rectangle(100.0, 100.0, 40.0, 60.0)

    found = matched([Answered("box", rectangle(100.0, 100.0, width, height))], box=seen(thing))

    assert HIT_IOU == 0.5
    assert column(found, "outcome")[0] == outcome


def test_a_second_answer_to_an_object_is_a_false_alarm_even_if_it_fits_better() -> None:
    found = matched([Answered("box", HERE, 0.6), Answered("box", HERE + 5.0, 0.9)], box=seen(HERE))

    assert column(found, "confidence")[:2] == [0.9, 0.6]
    assert column(found, "outcome")[:2] == [1.0, 2.0]
    assert column(found, "iou")[1] == 1.0


def test_an_answer_that_misses_leaves_the_object_to_the_next() -> None:
    found = matched([Answered("box", HERE + 50.0, 0.9), Answered("box", HERE, 0.6)], box=seen(HERE))

    assert column(found, "outcome")[:2] == [2.0, 1.0]


def test_of_equally_confident_answers_the_first_counts() -> None:
    found = matched([Answered("box", HERE + 5.0), Answered("box", HERE)], box=seen(HERE))

    assert column(found, "outcome")[:2] == [1.0, 2.0]
    assert column(found, "x0")[:2] == [105.0, 100.0]


def test_an_answer_with_the_wrong_label_is_a_false_alarm_on_what_it_lies_on() -> None:
    shell = rectangle(200.0, 200.0, 20.0, 20.0)

    found = matched(
        [Answered("box", HERE, 0.9), Answered("box", shell, 0.8), Answered("box", HERE + 120.0)],
        [("shell", shell)],
        pipe=seen(HERE),
    )

    assert column(found, "outcome")[:3] == [2.0, 2.0, 2.0]
    assert column(found, "on")[:3] == [PIPE, 100.0 + list(DECOYS).index("shell"), -1.0]
    assert column(found, "iou")[:3] == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(("height", "on"), [(12.0, PIPE), (11.9, -1.0)])
def test_an_answer_lies_on_what_it_overlaps_enough(height: float, on: float) -> None:
    found = matched([Answered("box", rectangle(100.0, 100.0, 60.0, height))], pipe=seen(HERE))

    assert ON_IOU == 0.3
    assert column(found, "on")[0] == on


def test_an_answer_lies_on_the_thing_that_it_overlaps_most_an_object_before_a_decoy() -> None:
    nearer = matched([Answered("box", HERE)], [("can", HERE + 1.0)], pipe=seen(HERE + 3.0))
    equal = matched([Answered("box", HERE)], [("can", HERE)], pipe=seen(HERE))

    assert column(nearer, "on")[0] == 100.0 + list(DECOYS).index("can")
    assert column(equal, "on")[0] == PIPE


@pytest.mark.parametrize(
    ("shift", "uncovered", "state", "visible"),
    [
        (0.0, 1.0, 1.0, 1.0),
        (0.0, VISIBLE, 1.0, VISIBLE),
        (0.0, VISIBLE - 0.001, 2.0, VISIBLE - 0.001),
        (-0.375, 1.0, 1.0, 0.625),
        (-0.375, 0.625, 2.0, 0.390625),  # together too little
        (-0.4375, 1.0, 2.0, 0.5625),
        (-1.0, 1.0, 0.0, 0.0),
        (0.0, 0.0, 2.0, 0.0),
    ],
)
@pytest.mark.parametrize("end", ["left", "right", "top", "bottom"])
def test_an_object_counts_if_enough_of_it_is_visible_and_in_the_image(
    end: str, shift: float, uncovered: float, state: float, visible: float
) -> None:
    width, height = SIZE
    thing = {
        "left": rectangle(-0.5 + 64.0 * shift, 100.0, 64.0, 64.0),
        "right": rectangle(width - 0.5 - 64.0 * (1.0 + shift), 100.0, 64.0, 64.0),
        "top": rectangle(100.0, -0.5 + 64.0 * shift, 64.0, 64.0),
        "bottom": rectangle(100.0, height - 0.5 - 64.0 * (1.0 + shift), 64.0, 64.0),
    }[end]

    found = matched([], box=seen(thing, uncovered))

    assert INSIDE == 0.6
    assert of_object(found, BOX, "state") == state
    assert of_object(found, BOX, "visible") == pytest.approx(visible, abs=1e-15)


def test_what_counts_of_a_tilted_object_is_its_area_and_not_that_of_its_bounding_box() -> None:
    # A diamond with its middle 10 px inside: 68 % of it, but less than 60 % of its bounding box.
    diamond = np.array([[9.5, 50.0], [59.5, 100.0], [9.5, 150.0], [-40.5, 100.0]])

    found = matched([], box=seen(diamond))

    assert of_object(found, BOX, "visible") == pytest.approx(1.0 - 0.5 * 0.8**2, rel=1e-12)
    assert of_object(found, BOX, "state") == 1.0


def test_a_thing_whose_bounding_box_alone_reaches_into_the_image_is_not_in_it() -> None:
    corner = np.array([[-50.0, 2.0], [2.0, -50.0], [3.0, -51.0], [-49.0, 1.0]])

    found = matched([Answered("box", corner)], box=seen(corner))

    assert of_object(found, BOX, "state") == 0.0
    assert column(found, "outcome")[0] == 2.0
    assert column(found, "iou")[0] == 0.0


def test_the_first_answer_to_an_ignored_object_is_ignored_and_the_second_is_not() -> None:
    found = matched([Answered("box", HERE, 0.9), Answered("box", HERE, 0.8)], box=seen(HERE, 0.2))

    assert column(found, "outcome")[:2] == [3.0, 2.0]
    assert column(found, "on")[:2] == [BOX, BOX]
    assert math.isnan(column(found, "error")[0])


def test_boxes_are_compared_within_the_image() -> None:
    thing = rectangle(-20.5, 100.0, 80.0, 40.0)

    found = matched([Answered("box", rectangle(-1e6, 100.0, 1e6 + 59.5, 40.0))], box=seen(thing))

    assert column(found, "outcome")[0] == 1.0
    assert column(found, "iou")[0] == 1.0
    assert column(found, "error")[0] > 1e5


@pytest.mark.parametrize("first", range(4))
@pytest.mark.parametrize("turn", [1, -1])
def test_the_corners_of_an_answer_may_begin_anywhere_and_go_either_way(
    first: int, turn: int
) -> None:
    order = [(first + turn * step) % 4 for step in range(4)]

    assert corner_error((HERE + np.array([0.0, 2.0]))[order].tolist(), HERE.tolist()) == 2.0


def test_corners_that_cross_over_have_an_error() -> None:
    assert corner_error(HERE[[0, 2, 1, 3]].tolist(), HERE.tolist()) > 20.0


def test_labels_of_no_class_count_for_nothing_and_take_no_slot() -> None:
    nonsense = [Answered("black box", HERE, 1.0) for _ in range(40)]

    found = matched([*nonsense, Answered("box", HERE, 0.1)], box=seen(HERE))

    assert found.unknown == 40
    assert column(found, "outcome") == [1.0] + [0.0] * 15


@pytest.mark.parametrize(
    "corners",
    [
        rectangle(50.0, 50.0, 0.0, 10.0),
        rectangle(50.0, 50.0, 10.0, 0.0),
        rectangle(-80.5, 50.0, 80.0, 10.0),
        rectangle(399.5, 50.0, 80.0, 10.0),
        rectangle(50.0, 1e6, 10.0, 10.0),
        np.full((4, 2), np.nan),
        np.array([[1.0, 1.0], [9.0, 1.0], [9.0, 9.0], [1.0, np.nan]]),
        np.array([[1.0, 1.0], [9.0, 1.0], [9.0, 9.0], [-np.inf, 9.0]]),
        np.full((4, 2), np.inf),
    ],
)
def test_answers_without_area_in_the_image_count_for_nothing(corners: Any) -> None:
    found = matched([Answered("box", corners, 1.0), Answered("box", HERE, 0.1)], box=seen(HERE))

    assert (found.unknown, found.without_area) == (0, 1)
    assert column(found, "outcome") == [1.0] + [0.0] * 15


@pytest.mark.parametrize("confidence", [math.nan, math.inf, -0.1, 1.1])
def test_answers_with_a_confidence_that_is_none_count_for_nothing(confidence: float) -> None:
    found = matched([Answered("box", HERE, confidence), Answered("box", HERE)], box=seen(HERE))

    assert found.without_area == 1
    assert column(found, "confidence")[:2] == [0.5, 0.0]


def test_the_sixteen_most_confident_of_thousands_count_the_earlier_first() -> None:
    confident = [Answered("box", HERE + index, 0.9) for index in range(10)]
    equal = [Answered("pipe", HERE + 0.01 * index, 0.5) for index in range(5000)]

    found = matched([*equal, *confident])

    assert column(found, "label") == [BOX] * 10 + [PIPE] * 6
    assert column(found, "x0")[10:] == [100.0 + 0.01 * index for index in range(6)]


numbers = st.floats(allow_nan=True, allow_infinity=True) | st.floats(-50.0, 450.0)
quadrilaterals = st.lists(st.tuples(numbers, numbers), min_size=4, max_size=4)


@given(
    answers=st.lists(
        st.builds(Answered, st.sampled_from([*CLASSES, "", "Box"]), quadrilaterals, numbers),
        max_size=30,
    ),
    things=st.lists(
        st.tuples(st.floats(-100.0, 450.0), st.floats(-100.0, 350.0), st.floats(0.0, 1.0)),
        min_size=16,
        max_size=16,
    ),
)
@settings(max_examples=50)
def test_whatever_the_answers_are_the_row_is_complete(
    answers: list[Answered], things: list[tuple[float, float, float]]
) -> None:
    places = [rectangle(left, top, 50.0, 30.0) for left, top, _ in things]
    objects = [seen(place, one[2]) for place, one in zip(places[:8], things, strict=False)]

    found = match(objects, places[8:], answers, SIZE)

    outcomes = column(found, "outcome")
    used = ANSWERS - outcomes.count(0.0)
    assert used == min(ANSWERS, len(answers) - found.unknown - found.without_area)
    assert 0.0 not in outcomes[:used]
    assert column(found, "confidence") == sorted(column(found, "confidence"), reverse=True)
    assert all(0.0 <= iou <= 1.0 for iou in column(found, "iou"))
    for slot, outcome in enumerate(outcomes):
        assert math.isnan(column(found, "error")[slot]) == (outcome != 1.0)
    for number in range(len(CLASSES)):
        mine = [
            outcome
            for label, outcome in zip(column(found, "label"), outcomes, strict=True)
            if label == number
        ]
        state = of_object(found, number, "state")
        assert mine.count(1.0) <= (state == 1.0)
        assert mine.count(3.0) <= (state == 2.0)
