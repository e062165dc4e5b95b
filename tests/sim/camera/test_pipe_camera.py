"""Images of a pipe: where its rays hit, what covers it, and what does not change beside it."""

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.camera.camera import Camera
from seamark.sim.camera.geometry import camera_pose, project
from seamark.sim.camera.optics import VISIBILITY
from seamark.sim.camera.pipe_camera import PipeCamera
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water
from seamark.sim.physics.pipe import Pipe, pipe_along

SEABED_M, RADIUS_M = 20.0, 0.2
TARGET = Target(
    length_m=0.1, width_m=0.1, height_m=0.1, north_m=50.0, seabed_m=SEABED_M, lettered=False
)
WATER = Water.grey(0.1)
STRAIGHT = pipe_along(np.array([[-9.0, 0.5], [9.0, 0.5]]), SEABED_M, RADIUS_M, seed=3)
POSES = [
    np.array([0.3, 0.2, 16.5, 0.0, 0.0, 0.4]),
    np.array([-1.0, 1.1, 16.6, 0.1, -0.15, 2.0]),
    np.array([2.0, -0.4, 16.2, -0.2, 0.1, -1.3]),
]


def camera(pipe: Pipe = STRAIGHT) -> PipeCamera:
    return PipeCamera(VISIBILITY, WATER, TARGET, pipe, noise_seed=5)


def pixels(pose: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    rotation, centre, out = np.empty((3, 3)), np.empty(3), np.empty((len(points), 2))
    camera_pose(pose, np.array(VISIBILITY.mount_m), rotation, centre)
    project(points, rotation, centre, VISIBILITY.intrinsics(), out)
    return out


def on_pipe(pose: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Points along the pipe, `share` of its radius to starboard of its axis, in the image."""
    north = np.linspace(-3.0, 3.0, 121)
    east = np.full_like(north, 0.5 + share * RADIUS_M)
    up = RADIUS_M * np.sqrt(max(0.0, 1.0 - share * share))
    seen = pixels(pose, np.stack([north, east, np.full_like(north, SEABED_M - up)], axis=1))
    inside = (seen > 2.0).all(axis=1) & (seen[:, 0] < 317.0) & (seen[:, 1] < 237.0)
    return np.round(seen[inside]).astype(int)


@pytest.mark.parametrize("pose", POSES)
def test_the_top_of_the_pipe_is_where_it_projects_to(pose: NDArray[np.float64]) -> None:
    plain = Camera(VISIBILITY, WATER, TARGET, noise_seed=5).grey(pose, 1).astype(float)
    image = camera().grey(pose, 1).astype(float)

    top = on_pipe(pose, 0.0)
    beside = np.concatenate([on_pipe(pose, -1.6), on_pipe(pose, 1.6)])

    assert len(top) > 20
    darker = plain[top[:, 1], top[:, 0]] - image[top[:, 1], top[:, 0]]
    assert (darker > 5.0).mean() > 0.9  # but for joints and thick growth
    assert np.array_equal(plain[beside[:, 1], beside[:, 0]], image[beside[:, 1], beside[:, 0]])


def test_a_pipe_stands_out_of_the_plane_of_its_axis() -> None:
    """Seen from the side, it hides the sand behind it, farther than its radius."""
    pose = np.array([0.0, -0.5, 16.5, 0.0, 0.0, 0.0])
    plain = Camera(VISIBILITY, WATER, TARGET, noise_seed=5).grey(pose, 1)
    image = camera().grey(pose, 1)

    north = np.linspace(-0.8, 0.8, 40)
    behind = np.stack([north, np.full(40, 0.5 + 1.05 * RADIUS_M), np.full(40, SEABED_M)], axis=1)
    before = behind - [0.0, 2.1 * RADIUS_M, 0.0]
    hidden, free = (np.round(pixels(pose, points)).astype(int) for points in (behind, before))

    assert (plain != image)[hidden[:, 1], hidden[:, 0]].mean() > 0.8
    assert not (plain != image)[free[:, 1], free[:, 0]].any()


def test_nothing_is_seen_of_a_covered_stretch() -> None:
    covered = STRAIGHT._replace(covered_m=np.array([[4.0, 14.0]]))
    plain = Camera(VISIBILITY, WATER, TARGET, noise_seed=5).grey(POSES[0], 1)

    assert np.array_equal(camera(covered).grey(POSES[0], 1), plain)
    assert not np.array_equal(camera().grey(POSES[0], 1), plain)


def test_there_is_no_gap_at_a_bend() -> None:
    bend = np.array([[-5.0, 0.0], [0.0, 0.0], [4.0, 1.6]])
    black = pipe_along(bend, SEABED_M, RADIUS_M, seed=3)
    pose = np.array([0.2, 0.1, 16.5, 0.0, 0.0, 0.0])
    plain = Camera(VISIBILITY, WATER, TARGET, noise_seed=5).grey(pose, 1)
    drawn = camera(black).grey(pose, 1) != plain

    angles = np.linspace(-1.2, 1.57, 60)  # around the outer side of the bend
    ring = 0.8 * RADIUS_M * np.stack([np.sin(angles), -np.cos(angles)], axis=1)
    up = RADIUS_M * 0.6
    seen = np.round(pixels(pose, np.column_stack([ring, np.full(60, SEABED_M - up)]))).astype(int)

    assert drawn[seen[:, 1], seen[:, 0]].mean() > 0.95


def test_a_window_has_the_pixels_of_the_whole_image() -> None:
    whole = camera().grey(POSES[1], 7)

    part = camera().region(POSES[1], 7, (40, 30, 250, 200))

    assert np.array_equal(part[30:200, 40:250], whole[30:200, 40:250])
