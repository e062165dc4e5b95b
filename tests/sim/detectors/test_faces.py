"""Detectors of lettered boxes: what they find, whether they can read, and the same everywhere."""

import hashlib
from itertools import product

import numpy as np
import pytest

from seamark.sim.camera.lettering import GLYPHS, TEXT
from seamark.sim.detectors import MOST, Detection, Image, declaration, make
from seamark.sim.detectors.faces.fitting import Levels
from seamark.sim.detectors.faces.picture import RIGHT
from seamark.sim.detectors.faces.reading import evidence
from seamark.sim.registry import BOX_DETECTORS
from tests.services.prepared import printed
from tests.sim.detectors.box_scenes import BoxView, look
from tests.sim.detectors.conftest import look as look_at_bottom
from tests.sim.detectors.test_detectors import said

NEAR, MIDDLE, FAR = 0.9, 1.6, 2.4  # [m] from camera to face
PAIRS, LONG = {(NEAR, 1.5), (MIDDLE, 0.5), (FAR, 2.5)}, pytest.mark.long

PROGRAM = """
from tests.sim.detectors.test_faces import digest
print(digest())
"""


def error_px(answer: Detection, view: BoxView) -> float:
    return float(np.sqrt(((answer.corners - view.corners) ** 2).sum(axis=1).mean()))


def confidence(name: str, view: BoxView) -> float:
    """Return the confidence in the box of a view: 0 if its corners were not found."""
    mine = [one.confidence for one in make(name).detect(view.image) if error_px(one, view) < 4.0]
    return max(mine, default=0.0)


def views(
    number: int, distance_m: float, optical_depth: float, *, right: bool, seed: int = 100
) -> list[BoxView]:
    random = np.random.default_rng(seed)
    return [look(random, distance_m, optical_depth, right=right) for _ in range(number)]


@pytest.mark.parametrize(
    ("distance_m", "optical_depth"),
    [  # each distance and each water once; the other pairs with the long tests
        pytest.param(distance_m, depth, marks=() if (distance_m, depth) in PAIRS else LONG)
        for distance_m, depth in product([NEAR, MIDDLE, FAR], [0.5, 1.5, 2.5])
    ],
)
def test_right_boxes_are_trusted_and_others_are_not(
    distance_m: float, optical_depth: float
) -> None:
    right = [confidence("face", view) for view in views(12, distance_m, optical_depth, right=True)]
    other = [confidence("face", view) for view in views(12, distance_m, optical_depth, right=False)]

    assert np.mean(np.array(right) > 0.8) >= 0.75
    assert np.mean(np.array(other) < 0.2) >= 0.9


def test_without_reading_both_boxes_are_trusted_alike() -> None:
    shares = [
        np.mean([confidence("outline", view) > 0.5 for view in views(12, MIDDLE, 1.0, right=right)])
        for right in (True, False)
    ]

    assert min(shares) >= 0.8


@pytest.mark.parametrize("name", BOX_DETECTORS)
def test_corners_are_within_a_pixel_and_in_reading_order(name: str) -> None:
    errors = [
        min(error_px(one, view) for one in make(name).detect(view.image))
        for view in views(12, MIDDLE, 1.0, right=True)
    ]

    assert np.sqrt(np.mean(np.square(errors))) < 1.0


def test_letters_that_cannot_be_told_apart_are_no_evidence() -> None:
    seen = Levels(20.0, 100.0, (50.0, 50.0, 50.0, 50.0), 5.0, 0.5)
    alike = np.full((len(TEXT), len(GLYPHS)), 900.0)
    clear = alike + 1e6
    clear[np.arange(len(TEXT)), RIGHT] = 900.0
    one_hidden = clear.copy()
    one_hidden[3] = clear[3, ::-1]

    nothing, much, less = (
        evidence(each, 200.0, seen, RIGHT) for each in (alike, clear, one_hidden)
    )

    assert abs(nothing) < 1e-9
    assert much > less > 10.0


@pytest.mark.parametrize("name", BOX_DETECTORS)
def test_nothing_is_found_in_a_veil(name: str) -> None:
    assert [make(name).detect(view.image) for view in views(6, MIDDLE, 8.0, right=True)] == [[]] * 6


@pytest.mark.parametrize("name", BOX_DETECTORS)
def test_painted_things_and_bare_ground_are_no_boxes(name: str) -> None:
    detector = make(name)

    answers = [
        one.confidence
        for seed in range(700_300, 700_306)
        for view in look_at_bottom(seed, 1.0)
        for one in detector.detect(view.image)
    ]

    assert sum(confidence > 0.2 for confidence in answers) <= 1


@pytest.mark.parametrize("name", BOX_DETECTORS)
@pytest.mark.parametrize("kind", ["noise", "black", "white", "grey", "stripes", "one bright"])
def test_images_of_anything_give_an_answer_within_the_limits(name: str, kind: str) -> None:
    random = np.random.default_rng(5)
    images = {
        "noise": random.integers(0, 256, (240, 320)),
        "black": np.zeros((240, 320)),
        "white": np.full((240, 320), 255),
        "grey": np.full((240, 320), 90),
        "stripes": np.indices((240, 320))[0] * 37 % 256,
        "one bright": np.eye(240, 320) * 255,
    }

    answer = make(name).detect(images[kind].astype(np.uint8))

    assert make(name).detect(images[kind][:16, :16].astype(np.uint8)) == []
    assert len(answer) <= MOST
    for label, corners, confidence in answer:
        assert label == "box"
        assert corners.shape == (4, 2)
        assert np.isfinite(corners).all()
        assert 0.0 <= confidence < 0.5
    assert [d.confidence for d in answer] == sorted((d.confidence for d in answer), reverse=True)


@pytest.mark.parametrize("name", BOX_DETECTORS)
def test_an_image_gives_the_same_answer_again_however_it_is_stored(name: str) -> None:
    (view,) = views(1, MIDDLE, 1.0, right=True)
    strided = np.repeat(view.image, 2, axis=1)[:, ::2]
    colour = np.dstack([view.image] * 3)

    first, *others = (
        said(make(name).detect(image))
        for image in (view.image, view.image, strided, np.asfortranarray(view.image), colour)
    )

    assert first
    assert others == [first] * 4


def test_larger_images_of_the_same_give_the_same_corners_in_their_pixels() -> None:
    (view,) = views(1, MIDDLE, 1.0, right=True)
    (found,) = make("face").detect(view.image)

    for factor in (2, 4):
        large = np.kron(view.image, np.ones((factor, factor), np.uint8))
        (again,) = make("face").detect(large)

        assert again.corners == pytest.approx(factor * (found.corners + 0.5) - 0.5, abs=1e-6)
        assert again.confidence == found.confidence


@pytest.mark.parametrize("name", BOX_DETECTORS)
def test_a_detector_has_a_label_and_answers_are_exact(name: str) -> None:
    assert declaration(name).label
    assert declaration(name).exact


def images() -> list[Image]:
    return [
        view.image
        for distance in (NEAR, FAR)
        for right in (True, False)
        for view in views(2, distance, 1.0, right=right, seed=200)
    ]


def digest() -> str:
    """Return the digest of what the detectors answer to some images."""
    whole = hashlib.sha256()
    for name in BOX_DETECTORS:
        detector = make(name)
        for image in images():
            whole.update(said(detector.detect(image)))
    return whole.hexdigest()


@pytest.mark.slow
def test_the_oldest_processor_gives_the_same_bytes() -> None:
    assert printed(PROGRAM, on="oldest").strip() == digest()
