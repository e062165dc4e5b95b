"""Trackers made of OpenCV's parts, on the same sequences as our own."""

from typing import Any

import cv2
import numpy as np
import pytest

from seamark.sim.camera import VISIBILITY, Camera, Water, start_pose
from seamark.sim.registry import TRACKERS, benchmark
from seamark.sim.trackers import declaration, make
from seamark.sim.trackers.template.warps import signed_area
from seamark.sim.trackers.visp.installation import unavailable_reason

AVAILABLE = [name for name in TRACKERS if name != "visp" or not unavailable_reason()]

Sequence = Any  # conftest's class; a test folder is no package


@pytest.mark.parametrize(
    ("name", "options", "limit_px"),
    [
        ("klt", {}, 1.5),
        ("klt", {"klt_from": "previous"}, 2.0),
        ("klt", {"warp": "affine"}, 1.5),
        ("klt", {"warp": "srt"}, 1.5),
        ("ecc", {}, 1.5),
        ("ecc", {"warp": "affine"}, 1.5),
    ],
)
def test_the_target_is_followed(
    short: Sequence, name: str, options: dict[str, Any], limit_px: float
) -> None:
    errors, sure = short.follow(make(name, **options))

    assert sure.all()
    assert errors.max() < limit_px


@pytest.mark.parametrize("name", ["klt", "ecc"])
def test_a_target_out_of_the_image_is_lost_and_found_where_it_was(
    blackout: Sequence, name: str
) -> None:
    errors, sure = blackout.follow(make(name))

    assert sure[:19].all()
    assert not sure[19:39].any()
    assert sure[40:].all()
    assert errors[40:].max() < 1.5


@pytest.mark.parametrize(("name", "limit_px"), [("klt", 1.5), ("ecc", 0.1)])
def test_a_target_that_moves_six_pixels_an_image_is_followed(
    brisk: Sequence, name: str, limit_px: float
) -> None:
    errors, sure = brisk.follow(make(name))

    assert brisk.fastest() > 6.0
    assert sure.all()
    later = errors[1:]  # the motion is not known yet at the first image
    assert np.sqrt((later**2).mean()) < limit_px


def test_ecc_errs_by_hundredths_of_a_pixel(short: Sequence) -> None:
    errors, _ = short.follow(make("ecc"))

    assert np.sqrt((errors**2).mean()) < 0.1


@pytest.mark.parametrize("name", ["klt", "ecc"])
def test_a_target_learnt_in_clear_water_is_followed_at_optical_depth_three(
    short: Sequence, name: str
) -> None:
    murky = Camera(VISIBILITY, Water.grey(3.0 / 1.27), short.camera.target, noise_seed=4)
    tracker = make(name)
    tracker.start(short.camera.grey(short.poses[0], 0), short.truth[0])

    tracks = [tracker.update(murky.grey(short.poses[k], k)) for k in range(1, 12)]

    assert all(track.ok for track in tracks)
    assert np.abs(tracks[-1].corners - short.truth[11]).max() < 3.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["box", "kcf", "csrt"])
def test_an_upright_box_follows_to_some_pixels(short: Sequence, name: str) -> None:
    errors, sure = short.follow(make(name))

    assert sure.all()
    assert errors.max() < 10.0


@pytest.mark.slow
def test_the_box_of_csrt_grows_with_the_target_and_that_of_kcf_does_not(short: Sequence) -> None:
    near = start_pose(VISIBILITY, short.camera.target, 1.5)
    down = np.array([0.0, 0.0, 0.02, 0.0, 0.0, 0.0])
    areas = {}
    for name in ("kcf", "csrt"):
        tracker = make(name)
        tracker.start(short.camera.grey(near, 0), short.camera.corners(near))
        for k in range(1, 16):
            corners = tracker.update(short.camera.grey(near + k * down, k)).corners
        areas[name] = signed_area(corners) / signed_area(short.camera.corners(near))

    assert areas["kcf"] == pytest.approx(1.0)
    assert areas["csrt"] > 1.3


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ecc", "klt", "kcf", "csrt"])
def test_the_number_of_threads_changes_nothing(brief: Sequence, name: str) -> None:
    before = cv2.getNumThreads()
    errors = []
    for threads in (1, 4):
        cv2.setNumThreads(threads)
        errors.append(brief.follow(make(name))[0])
    cv2.setNumThreads(before)

    assert np.array_equal(*errors)


@pytest.mark.parametrize(("name", "warp"), [("klt", "rt"), ("klt", "translation"), ("ecc", "srt")])
def test_warps_that_opencv_does_not_have_are_refused_with_the_reason(name: str, warp: str) -> None:
    with pytest.raises(ValueError, match=f"{name} does not support warp {warp}: OpenCV"):
        make(name, warp=warp)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["klt", "ecc", "kcf", "box", pytest.param("csrt", marks=pytest.mark.long)]
)
def test_a_tracker_that_starts_again_makes_the_same_errors(short: Sequence, name: str) -> None:
    first, second = (short.follow(make(name))[0] for _ in range(2))

    assert np.array_equal(first, second)


@pytest.mark.parametrize("name", AVAILABLE)
def test_form_and_configuration_name_trackers_that_depend_on_the_processor(name: str) -> None:
    currents = benchmark("currents-v1")
    labels = currents.configuration.model_fields["tracker"].json_schema_extra["x-labels"]

    config = currents.read({"tracker": name, "warp": "affine", "method": "inverse_compositional"})

    assert config.exact() == declaration(name).exact
    assert ("not bit-identical on all processors" in labels[name]) == (not config.exact())
