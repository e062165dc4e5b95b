"""Average precision: its laws, and the same numbers as COCO's own evaluation of random scenes."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from seamark.sim.metrics.average_precision import RECALLS, average_precision, ranked
from seamark.sim.metrics.recognition import AP, CLASS_GROUP, level_metrics
from seamark.sim.recording.telemetry import ANSWERS, Rows, names
from seamark.sim.vehicles.patterns import CLASSES
from tests.sim.metrics.detector_rows import SIZE, Answered, Image, rectangle, rows_of, seen

OUT_OF_RANGE = 1e12  # [px²] area of an ignored object, beyond the range that counts


def precision(answers: list[tuple[float, bool]], objects: int) -> float:
    confidence = np.array([confidence for confidence, _ in answers], float)
    return average_precision(confidence, np.array([hit for _, hit in answers], bool), objects)


@st.composite
def answered(draw: st.DrawFn) -> tuple[list[tuple[float, bool]], int]:
    """Return answers, of which some are equally confident, and a number of objects."""
    confidence = st.integers(0, 20).map(lambda step: step / 20.0) | st.floats(0.0, 1.0)
    answers = draw(st.lists(st.tuples(confidence, st.booleans()), max_size=60))
    hits = sum(hit for _, hit in answers)
    return answers, draw(st.integers(max(hits, 1), hits + 20))


@settings(max_examples=50)
@given(answered())
def test_it_is_a_share_and_no_more_than_the_recall_allows(
    given: tuple[list[tuple[float, bool]], int],
) -> None:
    answers, objects = given
    recall = sum(hit for _, hit in answers) / objects

    assert 0.0 <= precision(answers, objects) <= (100.0 * recall + 1.0 + 1e-9) / 101.0


@settings(max_examples=50)
@given(answered())
def test_only_the_order_of_the_confidences_matters(
    given: tuple[list[tuple[float, bool]], int],
) -> None:
    answers, objects = given
    order = sorted({confidence for confidence, _ in answers})
    moved = [(-1.0 / (1.0 + order.index(one)), hit) for one, hit in answers]

    assert precision(moved, objects) == precision(answers, objects)


@settings(max_examples=50)
@given(answered(), st.floats(0.0, 1.0), st.data())
def test_a_false_alarm_more_never_raises_it_and_a_hit_more_never_lowers_it(
    given: tuple[list[tuple[float, bool]], int], confidence: float, data: st.DataObject
) -> None:
    answers, objects = given
    at = data.draw(st.integers(0, len(answers)))
    before, after = answers[:at], answers[at:]

    worse = precision([*before, (confidence, False), *after], objects)
    better = precision([*before, (confidence, True), *after], objects + 1)

    assert worse <= precision(answers, objects)
    assert better >= precision(answers, objects + 1)


@settings(max_examples=50)
@given(answered())
def test_false_alarms_below_all_hits_cost_nothing(
    given: tuple[list[tuple[float, bool]], int],
) -> None:
    answers, objects = given

    assert precision([*answers, *[(-1.0, False)] * 30], objects) == precision(answers, objects)


@pytest.mark.parametrize("objects", [1, 2, 7, 100, 1000])
def test_perfect_answers_give_exactly_one(objects: int) -> None:
    assert precision([(0.5, True)] * objects, objects) == 1.0


def test_no_answer_gives_nothing_and_nothing_to_be_found_gives_no_number() -> None:
    assert precision([], 5) == 0.0
    assert math.isnan(precision([(0.5, False)], 0))


def test_the_mean_is_over_the_largest_precision_from_each_recall_on() -> None:
    answers = [(0.9, True), (0.8, False), (0.7, False), (0.6, True), (0.5, True), (0.4, False)]

    # 3 of 4 found. Recall up to 0.25: precision 1; up to 0.75: 3 / 5, more than the 2 / 4 before.
    expected = (26 * 1.0 + 50 * 0.6) / 101
    assert precision(answers, 4) == pytest.approx(expected, rel=1e-15)


def test_equally_confident_answers_count_in_the_order_in_which_they_came() -> None:
    assert precision([(0.5, True), (0.5, False)], 1) == 1.0
    assert precision([(0.5, False), (0.5, True)], 1) == 0.5


def test_a_threshold_never_lies_between_equally_confident_answers() -> None:
    confidence, hit = np.array([0.5, 0.9, 0.5, 0.5, 0.1]), np.array([1, 0, 1, 0, 1], bool)

    possible = ranked(confidence, hit).at_thresholds()

    assert possible.confidence.tolist() == [0.9, 0.5, 0.1]
    assert possible.hits.tolist() == [0, 2, 3]
    assert possible.false_alarms.tolist() == [1, 2, 2]
    assert len(ranked(confidence[:0], hit[:0]).at_thresholds().hits) == 0


def _scene(seed: int) -> list[Image]:
    """Return images with objects, some of them ignored, and answers good and bad.

    All coordinates are multiples of an eighth, so that no rounding decides whether an intersection
    over union is a half.
    """
    random = np.random.default_rng(seed)
    return [_image(random) for _ in range(random.integers(3, 40))]


def _image(random: np.random.Generator) -> Image:
    present = [name for name in CLASSES if random.random() < 0.6]
    objects = {
        name: seen(_somewhere(random), uncovered=random.choice([1.0, 0.9, 0.3])) for name in present
    }
    answers = [
        Answered(label, corners, float(random.choice([0.1, 0.3, 0.5, 0.7, random.random()])))
        for label, corners in _answered(
            random, {name: one.corners for name, one in objects.items()}
        )
    ]
    return Image(objects, answers)


def _somewhere(random: np.random.Generator) -> NDArray[np.float64]:
    left, top = random.integers(-300, 8 * 380), random.integers(-300, 8 * 280)
    width, height = random.integers(60, 640, 2)
    return rectangle(left / 8.0, top / 8.0, width / 8.0, height / 8.0)


def _answered(
    random: np.random.Generator, objects: dict[str, NDArray[np.float64]]
) -> Iterator[tuple[str, NDArray[np.float64]]]:
    for _ in range(random.integers(0, ANSWERS + 1)):
        label = str(random.choice([*(objects or CLASSES), *CLASSES]))
        near = objects.get(str(random.choice([label, *CLASSES])))
        moved = random.integers(-80, 80, (4, 2)) / 8.0
        yield label, _somewhere(random) if near is None else near + moved[[0, 0, 0, 0]] + moved // 4


def _bounding_box(corners: NDArray[np.float64]) -> list[float]:
    """Return left, top, width, height within the image; the width or height of none is negative."""
    far = np.array(SIZE) - 0.5
    least, most = np.maximum(corners.min(axis=0), -0.5), np.minimum(corners.max(axis=0), far)
    return [*least.tolist(), *(most - least).tolist()]


def _judged(images: list[Image], rows: Rows) -> Any:
    """Return COCO's evaluation of the images, in which some objects are out of the area range."""
    at = names(rows.shape[1]).index
    truth, answers = [], []
    for number, (image, row) in enumerate(zip(images, rows, strict=True)):
        for index, name in enumerate(CLASSES):
            if name in image.objects and row[at(f"object_{index}_state")]:
                truth.append(
                    {
                        "id": len(truth) + 1,
                        "image_id": number,
                        "category_id": index,
                        "bbox": _bounding_box(image.objects[name].corners),
                        "area": {1.0: 1.0, 2.0: OUT_OF_RANGE}[row[at(f"object_{index}_state")]],
                        "iscrowd": 0,
                    }
                )
        answers += [
            {
                "image_id": number,
                "category_id": list(CLASSES).index(one.label),
                "bbox": box,
                "score": one.confidence,
            }
            for one in image.answers
            if min((box := _bounding_box(one.corners))[2:]) > 0.0
        ]
    known = COCO()
    known.dataset = {
        "images": [{"id": number} for number in range(len(images))],
        "annotations": truth,
        "categories": [{"id": index} for index in range(len(CLASSES))],
        "info": {},
    }
    known.createIndex()
    judge = COCOeval(known, known.loadRes(answers), "bbox")
    judge.params.iouThrs = np.array([0.5])
    judge.params.areaRng, judge.params.areaRngLbl = [[0.0, 0.5 * OUT_OF_RANGE]], ["counts"]
    judge.params.maxDets = [ANSWERS]
    judge.evaluate()
    judge.accumulate()
    return judge


def further(seeds: range) -> list[Any]:
    """Return seeds of the long tests."""
    return [pytest.param(seed, marks=pytest.mark.long) for seed in seeds]


@pytest.mark.parametrize("seed", [*range(20), *further(range(20, 60))])
def test_the_average_precision_of_random_scenes_is_that_of_coco(seed: int) -> None:
    images = _scene(seed)
    rows = rows_of(images)

    judge = _judged(images, rows)
    found = level_metrics(rows, image_period_s=0.05, focal_px=300.0)

    by_class = judge.eval["precision"][0, :, :, 0, 0].mean(axis=0).tolist()
    known = [value for value in by_class if value >= 0.0]
    assert np.array_equal(judge.params.recThrs, RECALLS)
    assert found[AP.name] == pytest.approx(100.0 * sum(known) / len(known), abs=1e-10)
    for metric, value in zip(CLASS_GROUP.metrics, by_class, strict=True):
        if value < 0.0:
            assert found[metric.name] is None
        else:
            assert 0.01 * found[metric.name] == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize("seed", [*range(60, 68), *further(range(68, 80))])
def test_coco_finds_the_same_hits_and_ignores_the_same_answers(seed: int) -> None:
    images = _scene(seed)
    rows = rows_of(images)

    judge = _judged(images, rows)

    at = names(rows.shape[1]).index
    ours = {
        (number, label): [
            row[at(f"answer_{slot}_outcome")]
            for slot in range(ANSWERS)
            if row[at(f"answer_{slot}_label")] == label
        ]
        for number, row in enumerate(rows)
        for label in range(len(CLASSES))
    }
    compared = 0
    for one in filter(None, judge.evalImgs):
        matches, ignored = one["dtMatches"][0] > 0.0, one["dtIgnore"][0]
        theirs = np.where(ignored, 3.0, np.where(matches, 1.0, 2.0)).tolist()
        assert ours[one["image_id"], one["category_id"]] == theirs
        compared += len(theirs)
    assert compared == sum(map(len, ours.values())) > 0
