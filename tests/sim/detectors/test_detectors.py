"""Detectors on painted bottoms: what they find, what they leave alone, and the same everywhere."""

import hashlib
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from seamark.sim.detectors import MOST, Detection, declaration, make, option_errors, option_names
from seamark.sim.detectors.template.library import (
    STORED,
    _seen,
    library,
    painted,
    painted_tile,
)
from seamark.sim.registry import DETECTORS, REFERENCE_DETECTORS
from seamark.sim.settings.detector import DetectorSettings
from seamark.sim.vehicles.patterns import CLASSES, MARKERS
from tests.services.prepared import printed

View = Any  # conftest's class; a test folder is no package
EVERY = [*DETECTORS, *REFERENCE_DETECTORS]

PROGRAM = """
import sys
from tests.sim.detectors.test_detectors import digest
print(digest(sys.argv[1:]))
"""
QUICK = [name for name in EVERY if name != "network"]  # it takes ten seconds on that processor


def overlap(one: np.ndarray, other: np.ndarray) -> float:
    low = np.maximum(one.min(axis=0), other.min(axis=0))
    high = np.minimum(one.max(axis=0), other.max(axis=0))
    common = np.prod(np.maximum(high - low, 0.0))
    return float(common / (np.prod(np.ptp(one, axis=0)) + np.prod(np.ptp(other, axis=0)) - common))


def hits(name: str, views: list[View], labels: tuple[str, ...]) -> tuple[int, int]:
    """Return how many objects the best answers of their class hit, and of how many."""
    detector, found, of = make(name), 0, 0
    for view in views:
        answers: dict[str, Detection] = {}
        for answer in detector.detect(view.image):
            answers.setdefault(answer.label, answer)
        for label in labels:
            if label in view.objects:
                of += 1
                found += (
                    label in answers and overlap(answers[label].corners, view.objects[label]) >= 0.5
                )
    return found, of


def test_markers_in_clear_water_are_read_and_their_plates_are_within_three_pixels(
    clear_views: list[View],
) -> None:
    found, of = hits("markers", clear_views, MARKERS)
    errors = [
        np.abs(answer.corners - view.objects[answer.label]).max()
        for view in clear_views
        for answer in make("markers").detect(view.image)
        if answer.label in view.objects
    ]

    assert found >= 0.7 * of > 0
    assert max(errors) < 3.0


def test_template_matching_finds_most_boxes_in_clear_water(clear_views: list[View]) -> None:
    found, of = hits("template", clear_views, ("box",))

    assert found >= 0.7 * of > 0


def test_every_detector_finds_more_than_the_one_before_it(clear_views: list[View]) -> None:
    every = tuple(CLASSES)

    found = [hits(name, clear_views, every)[0] for name in ("nothing", "orb", "template")]

    assert found[0] == 0
    assert found == sorted(set(found))


@pytest.mark.parametrize("name", DETECTORS)
def test_nothing_is_found_in_a_veil(name: str, veiled_views: list[View]) -> None:
    detector = make(name)

    assert [detector.detect(view.image) for view in veiled_views] == [[]] * len(veiled_views)


@pytest.mark.parametrize("name", DETECTORS)
def test_a_colour_image_gives_the_answer_of_its_green_channel(
    name: str, clear_views: list[View]
) -> None:
    detector, image = make(name), clear_views[0].image

    assert said(detector.detect(image)) == said(detector.detect(image[:, :, 1].copy()))


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("kind", ["noise", "black", "white", "stripes", "coarse", "one bright"])
def test_images_of_anything_give_an_answer_within_the_limits(name: str, kind: str) -> None:
    random = np.random.default_rng(5)
    images = {
        "noise": random.integers(0, 256, (240, 320)),
        "black": np.zeros((240, 320)),
        "white": np.full((240, 320), 255),
        "stripes": np.indices((240, 320))[0] * 37 % 256,
        "coarse": np.kron(random.integers(0, 256, (12, 16)), np.ones((20, 20))),
        "one bright": np.eye(240, 320) * 255,
    }

    answer = make(name).detect(images[kind].astype(np.uint8))

    assert len(answer) <= MOST
    for label, corners, confidence in answer:
        assert label in CLASSES
        assert corners.shape == (4, 2)
        assert np.isfinite(corners).all()
        assert 0.0 <= confidence <= 1.0
    assert [d.confidence for d in answer] == sorted((d.confidence for d in answer), reverse=True)


def said(answer: list[Detection]) -> bytes:
    return b"".join(
        d.label.encode() + d.corners.tobytes() + np.float64(d.confidence).tobytes() for d in answer
    )


def digest(names: Sequence[str]) -> str:
    """Return the digest of what detectors answer to some images of every kind of water."""
    from tests.sim.detectors.conftest import look  # what the other process needs

    whole = hashlib.sha256()
    for name in names:
        detector = make(name)
        for depth in (0.0, 3.0):
            for view in look(700_200, depth)[:1]:
                whole.update(said(detector.detect(view.image)))
    return whole.hexdigest()


@pytest.mark.slow
@pytest.mark.parametrize(
    "names",
    [
        pytest.param(QUICK, id="all but the network"),
        pytest.param(["network"], id="network", marks=pytest.mark.long),
    ],
)
def test_the_oldest_processor_gives_the_same_bytes(names: Sequence[str]) -> None:
    assert printed(PROGRAM, *names, on="oldest").strip() == digest(names)


@pytest.mark.long
def test_the_stored_looks_are_those_that_the_painter_paints() -> None:
    assert np.array_equal(np.load(STORED), painted())


def test_what_the_painter_paints_is_like_the_stored_looks_of_its_kind_alone() -> None:
    tile, places = painted_tile(np.random.Generator(np.random.PCG64(1)), "sand")
    stored = library()

    def likeness(kind: int, of: int) -> float:
        north, east, length, _ = places[of]
        looks = stored.patches[stored.kinds == kind]
        return float((looks @ _seen(tile, north, east, length)[0]).max())

    kinds = range(len(places))
    assert np.mean([likeness(kind, kind) for kind in kinds]) > 0.75
    assert np.mean([likeness(kind, kind - 1) for kind in kinds]) < 0.5


@pytest.mark.parametrize("name", DETECTORS)
def test_every_option_is_a_setting_with_its_default(name: str) -> None:
    fields = DetectorSettings.model_fields

    defaults = {option: fields[option].default for option in option_names(name)}

    assert declaration(name).label
    assert defaults == {option.name: option.default for option in declaration(name).options}
    assert option_errors(name, defaults) == {}


def test_what_no_detector_has_is_refused() -> None:
    with pytest.raises(ValueError, match="must be one of template"):
        make("best")
    with pytest.raises(ValueError, match="has no option orb_features"):
        make("markers", orb_features=100)
    with pytest.raises(ValueError, match="orb_features must be from 50 to 2000"):
        make("orb", orb_features=1)
