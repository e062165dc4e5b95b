"""Image sequences with true corners, rendered by our camera, like those in the literature.

A vehicle moves in sums of sinusoids over a box whose top is 85x57 px in the first image of 320x240;
each tracker takes its template from that image. All images are rendered before the measurement, so
that rendering disturbs the caches of all trackers alike.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera import CURRENTS, VISIBILITY, Camera, Optics, Target, Water, start_pose

FRAMES = 100
RATE_HZ = 20.0
HEIGHT_M = 1.27  # S: the paper's visibility scene
BOX = Target(width_m=0.28)  # E: 85x57 px, a size for which the other libraries are known
_DEGREE = np.pi / 180.0
# E: amplitude, frequency [Hz] and phase of the sinusoids of north, east, down [m], roll, pitch, yaw
_WAVES = (
    ((0.15, 0.11, 0.3), (0.04, 0.37, 1.0)),
    ((0.15, 0.09, 2.0), (0.04, 0.41, 0.2)),
    ((0.15, 0.07, 0.0), (0.02, 0.33, 0.5)),
    ((3 * _DEGREE, 0.21, 0.1), (_DEGREE, 0.6, 2.0)),
    ((3 * _DEGREE, 0.17, 1.3), (_DEGREE, 0.5, 0.7)),
    ((8 * _DEGREE, 0.05, 0.0),),
)

_UNIT = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
PLAIN_MARGIN_PX = 6.0  # S: the margin of a uniform target's template in our earlier work


def transformed(
    old: NDArray[np.float64], new: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return points (n, 2) under the homography that maps one quadrilateral to another."""
    h = cv2.getPerspectiveTransform(old.astype(np.float32), new.astype(np.float32))
    moved = cv2.perspectiveTransform(points[:, None].astype(np.float64), h)
    return np.asarray(moved[:, 0], dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Sequence:
    """Images (n, H, W) and true corners (n, 4, 2) [px]."""

    images: NDArray[np.uint8]
    corners: NDArray[np.float64]
    margin_px: float = 0.0  # how far beyond the target all trackers are initialised

    def start_corners(self) -> NDArray[np.float64]:
        """Return the corners (4, 2) [px] that trackers are given with the first image."""
        quad = self.corners[0]
        width, height = (float(np.linalg.norm(quad[k] - quad[0])) for k in (1, 3))
        beyond = np.array([self.margin_px / width, self.margin_px / height])
        return transformed(_UNIT, quad, _UNIT + np.sign(_UNIT - 0.5) * beyond)

    def largest_step_px(self) -> float:
        """Return the largest displacement of a corner from one image to the next."""
        return float(np.linalg.norm(np.diff(self.corners, axis=0), axis=2).max())


def motion(frames: int, *, speed: float) -> NDArray[np.float64]:
    """Return poses (frames, 6) [m, rad] about the start, `speed` times as fast as _WAVES."""
    t = np.arange(frames) / RATE_HZ * speed
    columns = [
        sum((a * np.sin(2 * np.pi * f * t + p) for a, f, p in waves), np.zeros(frames))
        for waves in _WAVES
    ]
    return np.column_stack(columns)


def _rendered(
    optics: Optics, water: Water, speed: float, box: Target = BOX, margin_px: float = 0.0
) -> Sequence:
    camera = Camera(optics, water, box, noise_seed=3)
    poses = start_pose(optics, box, HEIGHT_M) + motion(FRAMES, speed=speed)
    images = np.stack([camera.grey(pose, k) for k, pose in enumerate(poses)])
    truth = np.stack([camera.corners(pose) for pose in poses])
    return Sequence(images, truth, margin_px)


# In order: the reference case, fast motion (over 12 px per image), low contrast (a fifth of the
# light arrives), a target without texture, and four times the pixels.
SEQUENCES: dict[str, Callable[[], Sequence]] = {
    "clear": lambda: _rendered(VISIBILITY, Water(), 1.0),
    "fast": lambda: _rendered(VISIBILITY, Water(), 2.6),
    "turbid": lambda: _rendered(VISIBILITY, Water.grey(1.2), 1.0),
    "plain": lambda: _rendered(
        VISIBILITY, Water(), 1.0, replace(BOX, lettered=False), PLAIN_MARGIN_PX
    ),
    "640x480": lambda: _rendered(CURRENTS, Water(), 1.0),
}

TURN_DEGREES = np.arange(0.0, 61.0, 5.0)


def turning_box(optics: Optics, height_m: float, noise_seed: int) -> Sequence:
    """Return the box of the benchmarks, seen by a vehicle that turns by TURN_DEGREES above it."""
    camera = Camera(optics, Water(), Target(), noise_seed=noise_seed)
    poses = np.tile(start_pose(optics, Target(), height_m), (len(TURN_DEGREES), 1))
    poses[:, 5] += TURN_DEGREES * _DEGREE
    images = np.stack([camera.grey(pose, k) for k, pose in enumerate(poses)])
    return Sequence(images, np.stack([camera.corners(pose) for pose in poses]))
