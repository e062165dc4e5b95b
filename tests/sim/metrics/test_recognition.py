"""Metrics of a detector over a level, from hand-made images, and how levels become a run."""

import math
from typing import Any

import numpy as np
import pytest

from seamark.sim.metrics.metric import over_run
from seamark.sim.metrics.recognition import (
    AP,
    CLASS_GROUP,
    LIES_ON,
    METRICS,
    confusion,
    curve_metrics,
    level_metrics,
    precision_recall,
)
from seamark.sim.recording.telemetry import Rows
from seamark.sim.vehicles.patterns import CLASSES, DECOYS
from tests.sim.metrics.detector_rows import Answered, Image, rectangle, rows_of, seen

PERIOD_S, FOCAL_PX = 0.5, 300.0
HERE, THERE = rectangle(100.0, 100.0, 60.0, 40.0), rectangle(200.0, 200.0, 60.0, 40.0)


def measured(rows: Rows) -> dict[str, Any]:
    return level_metrics(rows, image_period_s=PERIOD_S, focal_px=FOCAL_PX)


def level(*images: Image) -> dict[str, Any]:
    return measured(rows_of(images))


def boxes(*answers: Answered, count: int = 1) -> list[Image]:
    """Return images of a box, with the same answers to each."""
    return [Image({"box": seen(HERE)}, answers)] * count


EMPTY = Image({}, [])


def test_perfect_answers_have_the_best_of_everything() -> None:
    objects = {
        name: seen(rectangle(10.0 + 45.0 * at, 50.0, 40.0, 30.0)) for at, name in enumerate(CLASSES)
    }
    answers = [Answered(name, one.corners, 0.9) for name, one in objects.items()]

    found = level(*[Image(objects, answers)] * 10)

    assert found[AP.name] == found["recall_percent"] == found["precision_percent"] == 100.0
    assert (found["f_measure"], found["f_threshold"]) == (1.0, 0.9)
    assert {found[metric.name] for metric in CLASS_GROUP.metrics} == {100.0}
    assert (found["hits"], found["false_alarms_per_min"]) == (80.0, 0.0)
    assert found["hit_corner_px"] == found["hit_corner_m"] == 0.0
    assert found["held"] is True


def test_a_class_of_which_no_object_counted_is_left_out_of_the_mean() -> None:
    hidden = Image({"box": seen(HERE), "pipe": seen(THERE, 0.1)}, [Answered("box", HERE)])

    found = level(hidden)

    assert found[AP.name] == 100.0
    assert (found["ap_box_percent"], found["ap_pipe_percent"]) == (100.0, None)


def test_a_class_that_was_never_found_counts_as_nothing_in_the_mean() -> None:
    found = level(Image({"box": seen(HERE), "pipe": seen(THERE)}, [Answered("box", HERE)]))

    assert (found["ap_box_percent"], found["ap_pipe_percent"]) == (100.0, 0.0)
    assert found[AP.name] == 50.0


def test_a_level_without_objects_has_no_average_precision() -> None:
    found = level(Image({}, [Answered("box", HERE)]))

    assert math.isnan(found[AP.name])
    assert math.isnan(found["f_measure"])
    assert found["recall_percent"] is None
    assert found["held"] is False
    assert precision_recall(rows_of([EMPTY])) == []


def test_the_f_measure_is_that_of_the_best_threshold() -> None:
    answers = Answered("box", HERE, 0.8), Answered("box", THERE, 0.6), Answered("pipe", THERE, 0.2)

    found = level(*boxes(*answers, count=3), *boxes(Answered("box", HERE, 0.6)))

    # From 0.8 on: 3 hits of 4. From 0.6 on: all 4, but 3 false alarms: 8 / 11 < 6 / 7.
    assert found["f_measure"] == pytest.approx(6.0 / 7.0, rel=1e-15)
    assert found["f_threshold"] == 0.8


def test_without_a_hit_the_f_measure_is_zero_at_no_threshold() -> None:
    wrong, silent = level(*boxes(Answered("box", THERE))), level(*boxes())

    assert (wrong["f_measure"], wrong["f_threshold"]) == (0.0, None)
    assert (silent["f_measure"], silent["f_threshold"]) == (0.0, None)
    assert (silent["recall_percent"], silent["precision_percent"]) == (0.0, None)
    assert silent["hit_corner_px"] is silent["hit_corner_m"] is None
    assert silent["marker_side_px"] is None


def test_precision_and_recall_are_those_with_five_false_alarms_a_minute() -> None:
    # 36 images are 18 s, in which one false alarm is allowed and two are not.
    alarms = [Answered("box", THERE, confidence) for confidence in (0.7, 0.5, 0.3)]
    images = [
        *boxes(Answered("box", HERE, 0.9), count=3),
        *boxes(*alarms[:1]),
        *boxes(Answered("box", HERE, 0.6)),
        *boxes(Answered("box", HERE, 0.5), alarms[1]),
        *boxes(Answered("box", HERE, 0.3), alarms[2]),
    ]

    found = level(*images, *[EMPTY] * (36 - len(images)))

    assert found["recall_percent"] == pytest.approx(100.0 * 4.0 / 7.0, rel=1e-15)
    assert found["precision_percent"] == 80.0
    assert found["false_alarms_per_min"] == pytest.approx(3.0 / 0.3, rel=1e-12)


def test_exactly_five_false_alarms_a_minute_are_allowed() -> None:
    alarms = boxes(Answered("box", HERE), Answered("pipe", THERE))

    allowed, too_many = level(*alarms, *[EMPTY] * 23), level(*alarms, *[EMPTY] * 22)

    assert (allowed["recall_percent"], allowed["precision_percent"]) == (100.0, 50.0)
    assert (too_many["recall_percent"], too_many["precision_percent"]) == (0.0, None)


def test_ignored_answers_are_in_none_of_the_numbers() -> None:
    hidden = Image({"box": seen(HERE, 0.1)}, [Answered("box", HERE, 0.9)])
    images = boxes(Answered("box", HERE, 0.8), Answered("pipe", THERE, 0.7), count=4)

    assert level(*images, hidden) == level(*images, EMPTY)


def test_the_corner_error_is_the_median_of_the_hits_alone() -> None:
    def moved(by: float, distance: float) -> Image:
        answer = Answered("box", HERE + np.array([by, 0.0]))
        return Image({"box": seen(HERE, distance=distance)}, [answer])

    found = level(moved(1.0, 3.0), moved(2.0, 9.0), moved(4.0, 0.75), moved(50.0, 1.0))

    assert found["hits"] == 3.0
    assert found["hit_corner_px"] == 2.0
    assert found["hit_corner_m"] == pytest.approx(0.01, rel=1e-12)  # of 0.01, 0.06, 0.01


def test_markers_have_the_figures_of_the_hits_on_them() -> None:
    small = rectangle(50.0, 50.0, 10.0, 14.0)

    def image(label: str, corners: Any, distance: float, angle: float, *, hit: bool) -> Image:
        answers = [Answered(label, corners)] if hit else []
        return Image({label: seen(corners, distance=distance, angle=angle)}, answers)

    found = level(
        image("aruco", small, 2.0, 0.2, hit=True),
        image("apriltag", HERE, 1.0, 0.7, hit=True),
        image("apriltag", small / 2.0, 3.0, 0.9, hit=False),
        image("box", rectangle(50.0, 50.0, 5.0, 5.0), 4.0, 1.0, hit=True),
    )

    assert found["marker_side_px"] == 12.0
    assert found["marker_angle_rad"] == 0.7
    assert found["marker_distance_m"] == 2.0


def test_the_confusion_matrix_counts_answers_by_what_they_lie_on() -> None:
    rows = rows_of(
        [
            Image(
                {"box": seen(HERE), "pipe": seen(THERE)},
                [
                    Answered("box", HERE, 0.9),
                    Answered("panel", THERE, 0.8),
                    Answered("anode", rectangle(10.0, 10.0, 20.0, 20.0), 0.7),
                    Answered("amphora", rectangle(300.0, 10.0, 20.0, 20.0), 0.2),
                ],
                {"starfish": rectangle(300.0, 10.0, 20.0, 20.0)},
            ),
            Image({"box": seen(HERE, 0.1)}, [Answered("box", HERE)]),
        ]
    )

    def listed(threshold: float) -> dict[tuple[str, str], int]:
        counts = confusion(rows, threshold=threshold)
        return {
            (LIES_ON[on], list(CLASSES)[label]): int(counts[on, label])
            for on, label in np.argwhere(counts)
        }

    certain = {("box", "box"): 1, ("pipe", "panel"): 1, ("background", "anode"): 1}
    assert listed(0.0) == certain | {("starfish", "amphora"): 1}
    assert listed(0.7) == certain
    assert LIES_ON == (*CLASSES, *DECOYS, "background")


def test_the_area_below_the_curve_is_the_average_precision() -> None:
    random = np.random.default_rng(4)
    images = [
        Image(
            {"box": seen(HERE), "aruco": seen(THERE)},
            [
                Answered(str(random.choice(["box", "aruco"])), corners, random.random())
                for corners in (HERE, THERE, THERE + 30.0)
            ],
        )
        for _ in range(30)
    ]
    rows = rows_of(images)

    recall, precision = zip(*precision_recall(rows), strict=True)

    assert recall == tuple(np.linspace(0.0, 1.0, 101).tolist())
    assert list(precision) == sorted(precision, reverse=True)
    assert 100.0 * sum(precision) / 101 == pytest.approx(measured(rows)[AP.name], rel=1e-12)
    assert 0.0 < measured(rows)[AP.name] < 100.0


def test_the_curve_over_the_levels_has_the_numbers_of_the_level() -> None:
    rows = rows_of(boxes(Answered("box", HERE), Answered("box", THERE, 0.6), count=5))

    curve = curve_metrics(rows)

    assert curve == {name: measured(rows)[name] for name in curve}
    assert set(curve) == {AP.name, "f_measure"}


def test_a_level_that_has_just_begun_has_no_numbers_and_no_error() -> None:
    found = measured(rows_of([]))

    assert math.isnan(found[AP.name])
    assert math.isnan(found["false_alarms_per_min"])


def test_a_run_has_the_mean_of_the_levels_in_which_there_is_a_number() -> None:
    clear = level(*boxes(Answered("box", HERE + 1.0), count=3))
    turbid = level(
        Image({"pipe": seen(HERE)}, [Answered("pipe", HERE + 4.0), Answered("box", HERE)])
    )
    blind = level(*boxes())

    run = over_run(METRICS, [clear, turbid, blind])

    assert run["ap_percent"] == pytest.approx((100.0 + 100.0 + 0.0) / 3.0)
    assert (run["ap_box_percent"], run["ap_pipe_percent"]) == (50.0, 100.0)
    assert run["ap_anode_percent"] is None
    assert run["hits"] == 4.0
    assert run["hit_corner_px"] == pytest.approx(
        (3.0 * clear["hit_corner_px"] + turbid["hit_corner_px"]) / 4.0
    )
    assert run["f_threshold"] == 0.5
    assert run["marker_distance_m"] is None


def test_the_figures_of_markers_over_a_run_are_the_extremes() -> None:
    def found(size: float, distance: float) -> dict[str, Any]:
        corners = rectangle(50.0, 50.0, size, size)
        one = seen(corners, distance=distance, angle=0.1 * distance)
        return level(Image({"aruco": one}, [Answered("aruco", corners)]))

    run = over_run(METRICS, [found(20.0, 1.0), level(EMPTY), found(10.0, 2.0), found(30.0, 1.5)])

    assert run["marker_side_px"] == 10.0
    assert run["marker_distance_m"] == 2.0
    assert run["marker_angle_rad"] == pytest.approx(0.2)


def test_thousands_of_images_with_equal_confidences_take_no_longer_than_others() -> None:
    rows = np.tile(rows_of(boxes(Answered("box", HERE), Answered("box", THERE))), (20_000, 1))

    found = measured(rows)

    assert (found["hits"], found["recall_percent"]) == (20_000.0, 0.0)
    assert found["f_measure"] == pytest.approx(2.0 / 3.0)
