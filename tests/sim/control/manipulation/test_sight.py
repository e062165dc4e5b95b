"""A rectangle is found from its corners in the image, and nothing else is taken for one."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from seamark.sim.camera import Camera, Optics, Target, Water
from seamark.sim.control.manipulation.kinematics import rotation
from seamark.sim.control.manipulation.sight import Pinhole, Seen, find, find_tilted
from tests.sim.control.manipulation.pinhole import projected

OPTICS = Optics(width=320, height=240, focal_px=190.0, mount_m=(1.25, -0.35, 0.2))
TARGET = Target(length_m=0.3, width_m=0.2, height_m=0.2, heading_rad=0.7)
CAMERA = Pinhole(OPTICS.focal_px, OPTICS.principal_px, OPTICS.mount_m)
POSES = [
    (-1.2, 0.3, 3.3, 0.0, 0.0, 0.5),
    (-1.0, 0.4, 3.0, 0.05, -0.06, 0.2),
    (-1.0, 0.2, 3.6, -0.04, 0.05, 0.9),
]


def corners_at(pose: tuple[float, ...]) -> list[float]:
    camera = Camera(OPTICS, Water.grey(0.2), TARGET, noise_seed=1)
    corners: list[float] = camera.corners(np.array(pose)).ravel().tolist()
    return corners


SIZE_M = (0.3, 0.2)


def found(pose: tuple[float, ...], corners: list[float]) -> Seen | None:
    return find(corners, SIZE_M, CAMERA, rotation(pose[3], pose[4], 0.0))


@pytest.mark.parametrize("pose", POSES)
def test_its_centre_and_direction_are_found_whatever_the_attitude(pose: tuple[float, ...]) -> None:
    seen = found(pose, corners_at(pose))

    assert seen is not None
    off = TARGET.top_centre() - pose[:3]
    sine, cosine = np.sin(pose[5]), np.cos(pose[5])
    level = (cosine * off[0] + sine * off[1], cosine * off[1] - sine * off[0], off[2])
    assert seen.centre == pytest.approx(level, abs=1e-6)
    assert seen.yaw == pytest.approx(TARGET.heading_rad + 0.5 * np.pi - pose[5], abs=1e-6)


@pytest.mark.parametrize("attitude", [(0.0, 0.0), (0.05, -0.06)])
@pytest.mark.parametrize("about", [(0.0, 0.0), (0.14, 0.0), (-0.08, 0.1), (0.0, -0.25)])
def test_a_tilted_one_is_found_with_its_tilt_whatever_the_attitude(
    attitude: tuple[float, float], about: tuple[float, float]
) -> None:
    centre, yaw = np.array([1.1, -0.2, 1.5]), 0.7
    tilt = Rotation.from_rotvec([*about, 0.0]) * Rotation.from_euler("z", yaw)
    x, y = 0.5 * np.array(SIZE_M)
    corners = centre + tilt.apply([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)])
    pixels = projected(CAMERA, (*attitude, 0.0), corners)

    seen = find_tilted(pixels, SIZE_M, CAMERA, rotation(*attitude, 0.0))

    assert seen is not None
    assert seen.centre == pytest.approx(centre, abs=1e-9)
    assert seen.into == pytest.approx(tilt.apply([0.0, 0.0, 1.0]), abs=1e-9)
    along = tilt.apply([1.0, 0.0, 0.0])
    assert seen.yaw == pytest.approx(np.arctan2(along[1], along[0]), abs=1e-9)


@pytest.mark.parametrize("finder", [find, find_tilted])
def test_corners_of_no_rectangle_of_that_size_are_not_taken_for_it(finder: Any) -> None:
    square = [100.0, 100.0, 150.0, 100.0, 150.0, 150.0, 100.0, 150.0]
    point = [100.0] * 8
    unseen = [float("nan")] * 8

    level = rotation(0.0, 0.0, 0.0)
    seen = [finder(corners, SIZE_M, CAMERA, level) for corners in (square, point, unseen)]
    assert seen == [None] * 3
