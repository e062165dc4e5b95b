"""A level rectangle is found from its corners in the image, and nothing else is taken for one."""

import numpy as np
import pytest

from seamark.sim.camera import Camera, Optics, Target, Water
from seamark.sim.control.manipulation.kinematics import rotation
from seamark.sim.control.manipulation.sight import Pinhole, Seen, find

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


def found(pose: tuple[float, ...], corners: list[float]) -> Seen | None:
    return find(corners, (0.3, 0.2), CAMERA, rotation(pose[3], pose[4], 0.0))


@pytest.mark.parametrize("pose", POSES)
def test_its_centre_and_direction_are_found_whatever_the_attitude(pose: tuple[float, ...]) -> None:
    seen = found(pose, corners_at(pose))

    assert seen is not None
    off = TARGET.top_centre() - pose[:3]
    sine, cosine = np.sin(pose[5]), np.cos(pose[5])
    level = (cosine * off[0] + sine * off[1], cosine * off[1] - sine * off[0], off[2])
    assert seen.centre == pytest.approx(level, abs=1e-6)
    assert seen.yaw == pytest.approx(TARGET.heading_rad + 0.5 * np.pi - pose[5], abs=1e-6)


def test_corners_of_no_rectangle_of_that_size_are_not_taken_for_it() -> None:
    square = [100.0, 100.0, 150.0, 100.0, 150.0, 150.0, 100.0, 150.0]
    point = [100.0] * 8
    unseen = [float("nan")] * 8

    assert [found(POSES[0], corners) for corners in (square, point, unseen)] == [None] * 3
