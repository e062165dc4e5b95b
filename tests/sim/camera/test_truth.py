"""Where the target is in the image, by the camera's own account and by independent geometry."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seamark.sim.camera import CURRENTS, VISIBILITY, Camera, Optics, Target, Water, start_pose

Array = NDArray[np.float64]


def centroid(camera: Camera, pose: Array) -> Array:
    """Return the image point (2,) [px] of the top face's centre."""
    return np.array(camera.truth(pose)[8:10])


def origin(camera: Camera, pose: Array) -> Array:
    """Return the image point (2,) [px] of the box's centre."""
    return np.array(camera.truth(pose)[10:12])


@pytest.mark.parametrize(("optics", "height"), [(CURRENTS, 2.27), (VISIBILITY, 1.27)])
@pytest.mark.parametrize("heading", [0.0, 1.57, -2.3])
def test_start_pose_puts_the_target_upright_in_the_middle(
    optics: Optics, height: float, heading: float
) -> None:
    target = Target(heading_rad=heading, north_m=12.0, east_m=-7.0)
    camera = Camera(optics, Water(), target, noise_seed=0)

    pose = start_pose(optics, target, height)

    assert centroid(camera, pose) == pytest.approx(optics.principal_px, abs=1e-9)
    assert origin(camera, pose) == pytest.approx(optics.principal_px, abs=1e-9)
    half = np.array([target.length_m, target.width_m]) * optics.focal_px / height / 2
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    assert camera.corners(pose) == pytest.approx(optics.principal_px + signs * half, abs=1e-9)


def test_moving_to_starboard_moves_the_target_left_and_forwards_moves_it_down() -> None:
    target = Target()
    camera = Camera(VISIBILITY, Water(), target, noise_seed=0)
    start = start_pose(VISIBILITY, target, 1.27)
    middle = centroid(camera, start)

    starboard = centroid(camera, start + np.array([0, 0.1, 0, 0, 0, 0])) - middle
    forwards = centroid(camera, start + np.array([0.1, 0, 0, 0, 0, 0])) - middle

    step = 0.1 * 257.3 / 1.27
    assert starboard == pytest.approx([-step, 0], abs=1e-9)
    assert forwards == pytest.approx([0, step], abs=1e-9)


@given(shift=st.tuples(*[st.floats(-0.2, 0.2)] * 6))
@settings(max_examples=50, deadline=None)
def test_centroid_is_where_the_diagonals_of_the_corners_cross(shift: tuple[float, ...]) -> None:
    target = Target(heading_rad=0.4)
    camera = Camera(CURRENTS, Water(), target, noise_seed=0)
    pose = start_pose(CURRENTS, target, 2.27) + np.array(shift)

    c = np.column_stack([camera.corners(pose), np.ones(4)])

    crossing = np.cross(np.cross(c[0], c[2]), np.cross(c[1], c[3]))
    assert centroid(camera, pose) == pytest.approx(crossing[:2] / crossing[2], abs=1e-6)


def test_rays_through_the_true_corners_meet_the_box_corners(
    reference: Callable[..., object], tilted: Array
) -> None:
    target = Target()
    corners = Camera(VISIBILITY, Water(), target, noise_seed=0).corners(tilted)

    origin, ray = reference(VISIBILITY, Water(), target, 1).rays(tilted, *corners.T)

    top = target.seabed_m - target.height_m
    points = (origin[:, None] + (top - origin[2]) / ray[2] * ray).T
    assert points == pytest.approx(target.top_corners(), abs=1e-9)


def test_origin_is_off_the_visible_face_by_the_parallax_of_half_the_height() -> None:
    target = Target()
    camera = Camera(VISIBILITY, Water(), target, noise_seed=0)
    pose = start_pose(VISIBILITY, target, 1.27) + np.array([0, -0.48, 0, 0, 0, 0])

    parallax = centroid(camera, pose) - origin(camera, pose)

    expected = 257.3 * 0.48 * (1 / 1.27 - 1 / (1.27 + 0.065))
    assert parallax == pytest.approx([expected, 0], abs=1e-9)
    assert 4 < expected < 6  # the paper's trackers are off by about 5 px


def test_a_target_behind_the_camera_has_no_image_points() -> None:
    camera = Camera(VISIBILITY, Water(), Target(), noise_seed=0)

    assert np.isnan(camera.corners(np.array([0, 0, 5.5, 0, 0, 0.0]))).all()


@pytest.mark.parametrize(
    "build",
    [
        lambda: Water(law="milk"),
        lambda: Water(read_sigma_grey=0.5),
        lambda: Water(attenuation=(-1.0, 0.0, 0.0)),
        lambda: Water(veil=(2.0, 0.0, 0.0)),
        lambda: Water(shot_gain=-0.1),
        lambda: Target(height_m=0.0),
        lambda: Optics(width=8),
        lambda: Optics(focal_px=0.0),
    ],
)
def test_impossible_scenes_are_refused(build: Callable[[], object]) -> None:
    with pytest.raises(ValueError, match=r"\w+"):
        build()
