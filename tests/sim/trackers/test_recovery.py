"""A known warp of the image is recovered, and a covered target is lost and found again."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.trackers import make
from seamark.sim.trackers.options import WARPS
from seamark.sim.trackers.template import warps

Array = NDArray[np.float64]
LARGEST_STEP = 0.04  # of half the target's longer side, 68 px: 3 px for each parameter


@pytest.fixture(scope="module")
def first() -> tuple[NDArray[np.uint8], Array]:
    """A smooth image of the target in the middle, and the corners.

    Smooth, so that its resampling error is small compared with the tracker's.
    """
    camera = Camera(VISIBILITY, Water(), Target(), noise_seed=2)
    pose = start_pose(VISIBILITY, Target(), 0.8)
    smooth = cv2.GaussianBlur(camera.grey(pose, 0), (0, 0), 2.0)
    return smooth.astype(np.uint8), camera.corners(pose)


def _warped(corners: Array, warp: str, steps: tuple[float, ...]) -> Array:
    """Return a homography (3, 3) of the image: the warp's exponential about the target."""
    basis = warps.basis(warp)
    step = np.empty((3, 3))
    warps.exponential(basis @ np.array(steps[: basis.shape[1]]), step)
    middle = corners.mean(axis=0)
    half = 0.5 * np.linalg.norm(corners[1] - corners[0])
    unit = np.array([[half, 0.0, middle[0]], [0.0, half, middle[1]], [0.0, 0.0, 1.0]])
    return np.asarray(unit @ step @ np.linalg.inv(unit), dtype=np.float64)


@pytest.mark.parametrize("warp", WARPS)
@given(steps=st.tuples(*[st.floats(-LARGEST_STEP, LARGEST_STEP)] * 8))
@settings(max_examples=10, deadline=None)
def test_every_warp_recovers_a_warp_of_its_own_group(
    first: tuple[NDArray[np.uint8], Array], warp: str, steps: tuple[float, ...]
) -> None:
    image, corners = first
    h = _warped(corners, warp, steps)
    moved = cv2.warpPerspective(image, h, (320, 240), flags=cv2.INTER_LINEAR)
    truth = np.empty((4, 2))
    warps.apply(h, corners, truth)
    tracker = make("esm", warp=warp, fine_iterations=20, stop_px=0.01)
    tracker.start(image, corners)

    track = tracker.update(moved.astype(np.uint8))

    assert track.ok
    assert np.sqrt(((track.corners - truth) ** 2).sum(axis=1).mean()) < 0.1


@pytest.mark.parametrize("name", ["esm", "klt", "ecc", "kcf", "box"])
def test_a_covered_target_is_called_lost_and_followed_again_when_uncovered(
    first: tuple[NDArray[np.uint8], Array], name: str
) -> None:
    image, corners = first
    covered = image.copy()
    cv2.fillConvexPoly(covered, np.round(corners).astype(np.int32), 120)
    tracker = make(name)
    tracker.start(image, corners)

    seen = [tracker.update(each) for each in (image, covered, covered, image)]

    assert [track.ok for track in seen] == [True, False, False, True]
    assert np.abs(seen[-1].corners - corners).max() < 1.5


def test_a_target_that_moved_while_covered_is_found_again_by_looking_around(
    first: tuple[NDArray[np.uint8], Array],
) -> None:
    image, corners = first
    aside = np.roll(image, (-24, 50), axis=(0, 1))
    covered = image.copy()
    cv2.fillConvexPoly(covered, np.round(corners).astype(np.int32), 120)
    staying, looking = make("esm"), make("esm", reacquire_px=80)
    found = []
    for tracker in (staying, looking):
        tracker.start(image, corners)
        lost = [tracker.update(covered).ok for _ in range(4)]
        found.append([tracker.update(aside) for _ in range(6)][-1])

        assert not any(lost)

    assert not found[0].ok
    assert found[1].ok
    assert np.abs(found[1].corners - (corners + np.array([50, -24]))).max() < 0.3
