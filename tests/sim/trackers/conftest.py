"""Generated sequences with ground truth."""

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.camera import CURRENTS, VISIBILITY, Camera, Optics, Target, Water, start_pose
from seamark.sim.trackers import Tracker

Array = NDArray[np.float64]


def motion(frames: int, *, speed: float) -> Array:
    """Sums of sinusoids (frames, 6): +-0.19 m, altitude +-0.17 m, tilt +-4 and yaw +-8 degrees."""
    t = np.arange(frames) / 20.0 * speed
    degree = np.pi / 180

    def wave(*parts: tuple[float, float, float]) -> Array:
        return sum((a * np.sin(2 * np.pi * f * t + p) for a, f, p in parts), np.zeros(frames))

    return np.column_stack(
        [
            wave((0.15, 0.11, 0.3), (0.04, 0.37, 1.0)),
            wave((0.15, 0.09, 2.0), (0.04, 0.41, 0.2)),
            wave((0.15, 0.07, 0.0), (0.02, 0.33, 0.5)),
            wave((3 * degree, 0.21, 0.1), (degree, 0.6, 2.0)),
            wave((3 * degree, 0.17, 1.3), (degree, 0.5, 0.7)),
            wave((8 * degree, 0.05, 0.0)),
        ]
    )


class Sequence:
    """Poses over the default target, and what a tracker makes of them."""

    def __init__(self, optics: Optics, height: float, water: Water, poses: Array) -> None:
        target = Target()
        self.camera = Camera(optics, water, target, noise_seed=3)
        self.poses = start_pose(optics, target, height) + poses
        self.truth = np.array([self.camera.corners(pose) for pose in self.poses])

    def follow(self, tracker: Tracker) -> tuple[Array, NDArray[np.bool_]]:
        """Corner errors [px], RMS over the four corners, and the tracker's own opinion."""
        tracker.start(self.camera.grey(self.poses[0], 0), self.truth[0])
        errors, sure = [], []
        for k in range(1, len(self.poses)):
            track = tracker.update(self.camera.region(self.poses[k], k, tracker.window()))
            errors.append(np.sqrt(((track.corners - self.truth[k]) ** 2).sum(axis=1).mean()))
            sure.append(track.ok)
        return np.array(errors), np.array(sure)

    def fastest(self) -> float:
        """Largest way of a corner from one image to the next [px]."""
        return float(np.linalg.norm(np.diff(self.truth, axis=0), axis=2).max())


def visibility(water: Water, poses: Array) -> Sequence:
    return Sequence(VISIBILITY, 1.27, water, poses)


@pytest.fixture(scope="session")
def clear() -> Sequence:
    return visibility(Water(), motion(400, speed=1.0))


@pytest.fixture(scope="session")
def short() -> Sequence:
    return visibility(Water(), motion(25, speed=1.0))


@pytest.fixture(scope="session")
def brief() -> Sequence:
    return visibility(Water(), motion(9, speed=1.0))


@pytest.fixture(scope="session")
def jump() -> Sequence:
    """Still for 5 images, out of the image for 10, then back 60 px to the side."""
    poses = np.zeros((25, 6))
    poses[5:15, 1] = 2.0
    poses[15:, 1] = 0.3
    return visibility(Water(), poses)


@pytest.fixture(scope="session")
def turbid() -> Sequence:
    return visibility(Water.grey(0.8), motion(400, speed=1.0))


@pytest.fixture(scope="session")
def fast() -> Sequence:
    return visibility(Water(), motion(300, speed=2.6))


@pytest.fixture(scope="session")
def brisk() -> Sequence:
    return visibility(Water(), motion(60, speed=1.6))


@pytest.fixture(scope="session")
def climbing() -> Sequence:
    """Straight up from 1.27 m to 2.3 m in 10 s."""
    poses = np.zeros((200, 6))
    poses[:, 2] = -np.linspace(0.0, 1.03, 200)
    return visibility(Water(), poses)


@pytest.fixture(scope="session")
def wide() -> Sequence:
    return Sequence(CURRENTS, 2.27, Water(), motion(200, speed=1.0))


@pytest.fixture(scope="session")
def blackout() -> Sequence:
    """Still for 1 s, then the target out of the image for 1 s, then back."""
    poses = np.zeros((60, 6))
    poses[20:40, 1] = 2.0
    return visibility(Water(), poses)
