"""The detectors to start from find what lies on a bottom; in all languages they find the same."""

from functools import cache

import numpy as np
import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES, editor_starters
from seamark.sandbox.languages.language import DETECTOR
from seamark.sandbox.languages.sample import Sample
from seamark.sandbox.limits import Limits
from seamark.sandbox.protocol.answers import Detection
from tests.sandbox.languages import bottoms
from tests.sandbox.languages.bottoms import Image, overlap
from tests.services.languages import skip_without

pytestmark = pytest.mark.host

CONFORMANCE = [
    (name, sample)
    for name, language in LANGUAGES.items()
    for sample in language.conformance
    if sample.role == DETECTOR
]
STARTERS = [*editor_starters(DETECTOR).items()]
TURNS = np.linspace(0.0, np.pi, 8, endpoint=False).tolist()  # [rad]
GOOD = 0.7  # overlap with the true corners


def name_of(value: object) -> str:
    return value.upload_name if isinstance(value, Sample) else str(value)


@cache
def program(language: str, source: bytes, name: str, isolation: IsolationLevel) -> bytes:
    return compiled(LANGUAGES[language].sample_compiler, source, name, isolation=isolation)


def found_in(
    images: list[Image], language: str, sample: Sample, isolation: IsolationLevel
) -> list[list[Detection]]:
    """Return what a detector finds in images, one after the other in one box."""
    skip_without(language, isolation)
    source = program(language, sample.upload(), sample.upload_name, isolation)
    with Box(language, limits=Limits(), isolation=isolation) as box:
        box.load(source, sample.upload_name, {}, {"role": DETECTOR})
        return [box.detect(image) for image in images]


@cache
def pictures() -> list[Image]:
    """Return pictures of boxes and slabs in any direction, one in colour, one without a thing."""
    images = [bottoms.seen(bottoms.sand(0))]
    for seed, turn in enumerate(TURNS, 1):
        bottom = bottoms.sand(seed)
        bottoms.with_box(bottom, turn, (100.0 + seed, 90.5))
        bottoms.with_box(bottom, 2.0 * turn, (230.0, 160.0), letters=False)
        images.append(bottoms.seen(bottom, seed))
    green = images[1]
    images.append(np.ascontiguousarray(np.stack([green // 2, green, green // 3 * 2], axis=2)))
    return images


@pytest.mark.parametrize(("language", "sample"), CONFORMANCE[1:], ids=name_of)
def test_a_detector_gives_the_same_detections_in_all_languages(language, sample, isolation) -> None:
    expected = found_in(pictures(), *CONFORMANCE[0], isolation)

    assert found_in(pictures(), language, sample, isolation) == expected
    assert sum(map(len, expected)) >= len(TURNS)


@pytest.mark.parametrize(("language", "sample"), STARTERS, ids=name_of)
def test_a_detector_to_start_from_finds_a_box_in_any_direction(language, sample, isolation) -> None:
    bottom = [bottoms.sand(seed) for seed in range(len(TURNS))]
    boxes = [
        bottoms.with_box(one, turn, (150.0, 120.0)) for one, turn in zip(bottom, TURNS, strict=True)
    ]

    found = found_in([*map(bottoms.seen, bottom)], language, sample, isolation)

    assert [[one.label for one in each] for each in found] == [["box"]] * len(TURNS)
    for (one,), box in zip(found, boxes, strict=True):
        assert overlap(np.array(one.corners), box.corners) > GOOD


@pytest.mark.parametrize(("language", "sample"), STARTERS, ids=name_of)
def test_a_detector_to_start_from_finds_nothing_on_bare_sand(language, sample, isolation) -> None:
    assert found_in([bottoms.seen(bottoms.sand(5))], language, sample, isolation) == [[]]


@pytest.mark.parametrize("label", bottoms.DICTIONARIES)
def test_the_one_in_python_reads_markers(label, isolation) -> None:
    bottom = bottoms.sand(2)
    marker = bottoms.with_marker(bottom, label, 0.4, (120.0, 110.0))

    (found,) = found_in([bottoms.seen(bottom)], *STARTERS[0], isolation)

    assert [one.label for one in found] == [label]
    assert overlap(np.array(found[0].corners), marker.corners) > GOOD


def test_the_one_in_python_takes_no_slab_without_letters_for_a_box(isolation) -> None:
    bottom = bottoms.sand(3)
    bottoms.with_box(bottom, 0.3, (150.0, 120.0), letters=False)

    assert found_in([bottoms.seen(bottom)], *STARTERS[0], isolation) == [[]]


def test_the_one_in_python_sees_the_green_channel_of_a_colour_image(isolation) -> None:
    bottom = bottoms.sand(1)
    bottoms.with_box(bottom, 0.3, (150.0, 120.0))
    grey = bottoms.seen(bottom)
    colour = np.ascontiguousarray(np.stack([np.full_like(grey, 9), grey, grey // 2], axis=2))

    first, second = found_in([grey, colour], *STARTERS[0], isolation)

    assert first == second
    assert len(first) == 1
