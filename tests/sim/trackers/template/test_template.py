"""The template tracker on generated sequences with ground truth."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.registry import TRACKERS
from seamark.sim.trackers import make, option_errors
from seamark.sim.trackers.options import CRITERIA, METHODS, WARPS
from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

Sequence = Any  # conftest's class; a test folder is no package


@pytest.mark.slow
@pytest.mark.parametrize("criterion", CRITERIA)
@pytest.mark.parametrize("method", METHODS)
def test_homography_is_within_a_tenth_of_a_pixel(
    clear: Sequence, criterion: str, method: str
) -> None:
    errors, sure = clear.follow(make("esm", criterion=criterion, method=method))

    assert sure.all()
    assert np.sqrt((errors**2).mean()) < 0.10


@pytest.mark.parametrize(
    ("warp", "limit_px"), [("affine", 0.5), ("srt", 0.5), ("rt", 6.0), ("translation", 9.0)]
)
@pytest.mark.parametrize("criterion", CRITERIA)
def test_lesser_warps_err_by_what_they_cannot_represent(
    clear: Sequence, warp: str, limit_px: float, criterion: str
) -> None:
    errors, _ = clear.follow(make("esm", warp=warp, criterion=criterion))

    assert 0.1 < np.sqrt((errors**2).mean()) < limit_px


@pytest.mark.parametrize("warp", ["homography", "affine", "srt"])
def test_warps_with_scale_hold_the_target_when_the_vehicle_climbs(
    climbing: Sequence, warp: str
) -> None:
    errors, sure = climbing.follow(make("esm", warp=warp))

    assert sure.all()
    assert errors.max() < 1.0


@pytest.mark.parametrize("warp", ["translation", "rt"])
def test_warps_without_scale_lose_the_target_when_the_vehicle_climbs(
    climbing: Sequence, warp: str
) -> None:
    errors, sure = climbing.follow(make("esm", warp=warp))

    assert errors[-1] > 10.0
    assert not sure[-1]


def test_fast_motion_of_twelve_pixels_an_image_is_never_lost(fast: Sequence) -> None:
    errors, sure = fast.follow(make("esm"))

    assert fast.fastest() > 12.0
    assert sure.all()
    assert errors.max() < 0.5


def test_normalised_correlation_holds_in_turbid_water(turbid: Sequence) -> None:
    errors, sure = turbid.follow(make("esm", criterion="zncc"))

    assert sure.all()
    assert np.sqrt((errors**2).mean()) < 0.15


def test_larger_images_are_tracked_as_well(wide: Sequence) -> None:
    errors, sure = wide.follow(make("esm"))

    assert sure.all()
    assert np.sqrt((errors**2).mean()) < 0.10


def test_loss_is_admitted_and_the_target_found_again_where_it_was(blackout: Sequence) -> None:
    errors, sure = blackout.follow(make("esm"))

    assert sure[:19].all()
    assert not sure[19:39].any()
    assert sure[39:].all()
    assert errors[39:].max() < 0.3


def test_nothing_outside_the_window_is_read(clear: Sequence) -> None:
    trackers = [make("esm"), make("esm")]
    for tracker in trackers:
        tracker.start(clear.camera.grey(clear.poses[0], 0), clear.truth[0])

    for k in range(1, 30):
        image = clear.camera.grey(clear.poses[k], k)
        x0, y0, x1, y1 = trackers[0].window()
        masked = np.full_like(image, 255 * (k % 2))
        masked[y0:y1, x0:x1] = image[y0:y1, x0:x1]

        assert np.array_equal(trackers[0].update(image).corners, trackers[1].update(masked).corners)


def test_window_stays_inside_the_image(blackout: Sequence) -> None:
    tracker = make("esm", search_px=150)
    tracker.start(blackout.camera.grey(blackout.poses[0], 0), blackout.truth[0] + [120.0, 80.0])

    x0, y0, x1, y1 = tracker.window()

    assert 0 <= x0 < x1 <= 320
    assert 0 <= y0 < y1 <= 240


def test_truth_tracker_says_the_true_corners(clear: Sequence) -> None:
    corners = iter(clear.truth[1:])
    tracker = make("truth", truth=lambda: next(corners))

    errors, sure = clear.follow(tracker)

    assert errors.max() == 0.0
    assert sure.all()
    assert tracker.window() == (0, 0, 0, 0)


@pytest.mark.parametrize(
    ("name", "options", "reason"),
    [
        ("esm", {"criterion": "ncc"}, "must be one of zncc"),
        ("esm", {"method": ""}, "must be one of esm"),
        ("esm", {"warp": "spline"}, "must be one of translation"),
        ("esm", {"colour": "red"}, "has no option colour"),
        ("esm", {"template_margin_px": 1000}, "must be from -3 to 40"),
        ("esm", {"stop_px": float("nan")}, "must be from"),
        ("truth", {}, "source of the true corners"),
        ("truth", {"warp": "affine"}, "has no option warp"),
        ("surf", {}, "must be one of esm"),
    ],
)
def test_choices_that_are_not_offered_are_refused_with_a_reason(
    name: str, options: dict[str, Any], reason: str
) -> None:
    with pytest.raises(ValueError, match=reason):
        make(name, **options)


def test_a_template_too_small_or_twisted_is_refused() -> None:
    image = np.zeros((240, 320), np.uint8)
    small = np.array([[50, 50], [56, 50], [56, 54], [50, 54]], dtype=float)
    twisted = np.array([[50, 50], [150, 90], [150, 50], [50, 90]], dtype=float)

    with pytest.raises(ValueError, match="is not within"):
        make("esm").start(image, small)
    with pytest.raises(ValueError, match="convex"):
        make("esm").start(image, twisted)


def test_a_flat_image_is_lost_and_not_an_error() -> None:
    corners = np.array([[50, 50], [150, 50], [150, 90], [50, 90]], dtype=float)
    tracker = make("esm")
    tracker.start(np.full((240, 320), 90, np.uint8), corners)

    track = tracker.update(np.full((240, 320), 90, np.uint8))

    assert not track.ok
    assert np.array_equal(track.corners, corners)


@pytest.mark.parametrize("name", TRACKERS)
def test_every_tracker_that_is_on_this_machine_can_be_made(name: str) -> None:
    if errors := option_errors(name, {}):
        pytest.skip(" ".join(errors.values()))

    assert callable(make(name).update)


def test_registry_loads_neither_numba_nor_opencv() -> None:
    program = "import seamark.sim.trackers, sys; print({'numba', 'cv2'} & set(sys.modules))"

    said = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True).stdout

    assert said.strip() == b"set()"


def test_every_warp_and_criterion_has_a_label() -> None:
    assert list(WARPS) == ["translation", "rt", "srt", "affine", "homography"]
    assert all((WARPS | CRITERIA | METHODS).values())


# Of the simulator it compiles the tracker alone: the images are drawn before.
PROGRAM = """
import hashlib, sys, numpy as np
from seamark.sim.trackers import make
seen = np.load(sys.argv[1])
digest = hashlib.sha256()
other = {"criterion": "mi", "method": "forward_additional", "pyramid_levels": 3}
for options in ({}, other, {"smoothing": "image", "second_search": True, "max_jump": 1.0}):
    tracker = make("esm", reacquire_px=60, **options)
    tracker.start(seen["images"][0], seen["corners"])
    for image in seen["images"][1:]:
        track = tracker.update(image)
        digest.update(track.corners.tobytes() + np.float64(track.residual).tobytes())
print(digest.hexdigest(), track.ok)
"""


def draw(folder: Path) -> Path:
    """Write images in which the target is out of sight for a while, and its corners."""
    camera = Camera(VISIBILITY, Water.grey(1.0), Target(), noise_seed=5)
    start = start_pose(VISIBILITY, Target(), 1.27)
    poses = start + np.arange(25)[:, None] * [0.004, -0.006, 0.002, 0.001, -0.001, 0.003]
    poses[12:14, 1] += 3.0
    images = [camera.grey(pose, k) for k, pose in enumerate(poses)]
    path = folder / "images.npz"
    np.savez(path, images=np.stack(images), corners=camera.corners(start))
    return path


@pytest.mark.slow
def test_another_process_without_wide_vectors_tracks_to_the_same_bits(tmp_path: Path) -> None:
    drawn = str(draw(tmp_path))
    here = printed_here(PROGRAM, drawn)

    assert here == printed(PROGRAM, drawn, on="oldest")
    assert here.strip().endswith("True")
