"""What is drawn into the image of a detector's run."""

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.server.runs.showing.camera_view import (
    AMBER,
    GREEN,
    GREY,
    RED,
    Drawn,
    annotated,
)
from seamark.server.runs.showing.detections import answered, missed
from tests.sim.metrics.detector_rows import SIZE, Answered, Image, rectangle, rows_of, seen

BOX, PIPE, ANODE = (
    rectangle(60, 60, 80, 40),
    rectangle(200, 100, 60, 30),
    rectangle(40, 200, 60, 40),
)
IMAGE = Image(
    {"box": seen(BOX), "pipe": seen(PIPE), "anode": seen(ANODE, 0.1)},
    [
        Answered("box", BOX, 0.9),
        Answered("amphora", rectangle(300, 200, 40, 40), 0.5),
        Answered("anode", ANODE, 0.4),
    ],
)
SMOOTHED = 70  # of a channel: thin lines are smoothed
NOTHING = np.zeros((4, 2))  # corners of a target: there is none


def _drawn(drawn: Drawn) -> NDArray[np.uint8]:
    dark = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    return annotated(dark, rows_of([IMAGE])[0], NOTHING, drawn)


def _has(image: NDArray[np.uint8], colour: tuple[int, int, int]) -> bool:
    apart = np.abs(image.astype(int) - colour).max(axis=2)
    return bool((apart <= SMOOTHED).sum() > 20)


def test_answers_have_the_colour_of_their_outcome_and_missed_objects_are_amber() -> None:
    image = _drawn(Drawn())

    assert all(_has(image, colour) for colour in (GREEN, RED, GREY, AMBER))
    left, top = 2 * BOX[0]  # the image is twice as large
    assert image[int(top) + 30, int(left)].tolist() == list(GREEN)


@pytest.mark.parametrize(
    ("drawn", "shown", "hidden"),
    [
        (Drawn(truth=False), (GREEN, RED, GREY), (AMBER,)),
        (Drawn(tracked=False), (AMBER,), (GREEN, RED, GREY)),
    ],
)
def test_answers_and_missed_objects_can_be_hidden(
    drawn: Drawn, shown: tuple[tuple[int, int, int], ...], hidden: tuple[tuple[int, int, int], ...]
) -> None:
    image = _drawn(drawn)

    assert all(_has(image, colour) for colour in shown)
    assert not any(_has(image, colour) for colour in hidden)


def test_with_neither_the_image_is_bare() -> None:
    assert not _drawn(Drawn(tracked=False, truth=False)).any()


def test_answers_far_outside_the_image_are_no_error() -> None:
    corners = [[-1e9, 10.0], [1e9, 10.0], [1e9, 40.0], [-1e9, 40.0]]
    row = rows_of([Image({"box": seen(BOX)}, [Answered("box", corners)])])[0]

    image = annotated(np.zeros((SIZE[1], SIZE[0], 3), np.uint8), row, NOTHING, Drawn())

    assert _has(image, AMBER)  # the box that it did not hit


def test_an_object_that_is_ignored_or_hit_was_not_missed() -> None:
    row = rows_of([IMAGE])[0]

    assert [one.label for one in missed(row)] == ["pipe"]
    assert [(one.label, one.outcome) for one in answered(row)] == [
        ("box", "hit"),
        ("amphora", "false alarm"),
        ("anode", "ignored"),
    ]
