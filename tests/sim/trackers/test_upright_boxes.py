"""`mosse` and `median-flow`: boxes that move with their image, beside those of OpenCV."""

import hashlib
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.trackers import make
from seamark.sim.trackers.median_flow.flow import follow, pyramid
from seamark.sim.trackers.template.warps import signed_area
from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

Sequence = Any  # conftest's class; a test folder is no package
BOTH = ("mosse", "median-flow")
PEERS = {"mosse": cv2.legacy.TrackerMOSSE, "median-flow": cv2.legacy.TrackerMedianFlow}

BITS = """
import hashlib
import numpy as np
from seamark.sim.trackers import make

noise = np.random.default_rng(1).integers(0, 256, (30, 40))
image = np.kron(noise, np.ones((8, 8))).astype(np.uint8)
corners = np.array([[100.0, 90], [190, 95], [188, 150], [98, 145]])
total = hashlib.sha256()
for name in ("mosse", "median-flow"):
    tracker = make(name)
    tracker.start(image, corners)
    for k in range(12):
        track = tracker.update(np.roll(image, (k, 2 * k), (0, 1)) // (1 + k % 2))
        total.update(track.corners.tobytes() + np.float64(track.residual).tobytes())
print(total.hexdigest())
"""


def moved_image(right: float, down: float) -> NDArray[np.uint8]:
    """Return waves that are not the same anywhere, moved by so many pixels."""
    rows, columns = np.indices((240, 320)).astype(float)
    x, y = columns - right, rows - down
    waves = np.sin(0.11 * x + 0.0004 * x * y) + np.sin(0.17 * y - 0.0007 * x * x)
    return np.round(127.0 + 50.0 * waves).astype(np.uint8)


@pytest.mark.parametrize(("name", "limit_px"), [("mosse", 6.0), ("median-flow", 8.0)])
def test_it_follows_to_some_pixels_what_turns_and_rises(
    short: Sequence, name: str, limit_px: float
) -> None:
    errors, sure = short.follow(make(name))

    assert sure.all()
    assert errors.max() < limit_px


@pytest.mark.parametrize("name", BOTH)
def test_it_errs_no_more_than_the_one_of_opencv(short: Sequence, name: str) -> None:
    peer, images = PEERS[name].create(), []
    for pose, frame in zip(short.poses, range(len(short.poses)), strict=True):
        images.append(cv2.cvtColor(short.camera.grey(pose, frame), cv2.COLOR_GRAY2BGR))
    low, high = short.truth[0].min(axis=0), short.truth[0].max(axis=0)
    peer.init(images[0], tuple(np.round([*low, *(high - low)]).astype(int).tolist()))
    theirs = []
    for image, truth in zip(images[1:], short.truth[1:], strict=True):
        _ok, (x, y, width, height) = peer.update(image)
        middle = np.array([x + 0.5 * width, y + 0.5 * height])
        theirs.append(np.abs(middle - 0.5 * (truth.min(axis=0) + truth.max(axis=0))).max())

    tracker, ours = make(name), []
    tracker.start(short.camera.grey(short.poses[0], 0), short.truth[0])
    for frame in range(1, len(short.poses)):
        found = tracker.update(short.camera.grey(short.poses[frame], frame)).corners
        truth = short.truth[frame]
        middle = 0.5 * (found.min(axis=0) + found.max(axis=0))
        ours.append(np.abs(middle - 0.5 * (truth.min(axis=0) + truth.max(axis=0))).max())

    assert np.mean(ours) <= np.mean(theirs) + 0.1


@pytest.mark.parametrize("name", BOTH)
def test_a_target_out_of_the_image_is_lost_and_found_where_it_was(
    blackout: Sequence, name: str
) -> None:
    errors, sure = blackout.follow(make(name))

    assert sure[:19].all()
    assert not sure[19:39].any()
    assert sure[-1]
    assert errors[-1] < 2.0


@pytest.mark.parametrize("name", BOTH)
def test_it_moves_as_far_as_the_image(name: str) -> None:
    corners = np.array([[100.0, 80], [190, 80], [190, 140], [100, 140]])
    tracker = make(name)
    tracker.start(moved_image(0.0, 0.0), corners)

    for k in range(1, 6):
        track = tracker.update(moved_image(1.3 * k, -0.7 * k))

    assert track.ok
    assert track.corners - corners == pytest.approx(np.tile([6.5, -3.5], (4, 1)), abs=0.5)


def test_the_box_of_median_flow_grows_with_the_target_and_that_of_mosse_does_not() -> None:
    camera = Camera(VISIBILITY, Water(), Target(), noise_seed=3)
    near = start_pose(VISIBILITY, Target(), 1.5)
    down = np.array([0.0, 0.0, 0.02, 0.0, 0.0, 0.0])
    areas = {}
    for name in BOTH:
        tracker = make(name)
        tracker.start(camera.grey(near, 0), camera.corners(near))
        for k in range(1, 16):
            corners = tracker.update(camera.grey(near + k * down, k)).corners
        areas[name] = signed_area(corners) / signed_area(camera.corners(near))

    assert areas["mosse"] == pytest.approx(1.0)
    assert areas["median-flow"] > 1.4


def test_mosse_reads_only_the_window_that_it_asks_for() -> None:
    image, corners = moved_image(0, 0), np.array([[100.0, 80], [190, 80], [190, 140], [100, 140]])
    whole, part = make("mosse"), make("mosse")
    for tracker in (whole, part):
        tracker.start(image, corners)
    for k in range(1, 8):
        seen = moved_image(2.0 * k, 1.0 * k)
        x0, y0, x1, y1 = part.window()
        cut = np.zeros_like(seen)
        cut[y0:y1, x0:x1] = seen[y0:y1, x0:x1]

        assert np.array_equal(part.update(cut).corners, whole.update(seen).corners)


def test_the_flow_finds_a_displacement_of_part_of_a_pixel_and_none_where_nothing_is() -> None:
    old, new = pyramid(moved_image(0.0, 0.0)), pyramid(moved_image(3.4, -1.6))
    points, ends = np.array([[120.0, 100], [200, 150]]), np.empty((2, 2))
    follow(old, new, points, ends)
    assert ends - points == pytest.approx(np.tile([3.4, -1.6], (2, 1)), abs=0.1)

    blank = pyramid(np.full((240, 320), 90, np.uint8))
    follow(blank, blank, np.array([[np.nan, np.nan], [100.0, 100.0]]), ends)
    assert np.isnan(ends[0]).all()
    assert np.array_equal(ends[1], [100.0, 100.0])


def test_both_give_the_same_bits_as_on_the_oldest_processor() -> None:
    here = printed_here(BITS)

    assert here == printed(BITS, on="oldest")
    assert len(here.strip()) == 2 * hashlib.sha256().digest_size
