"""The camera above a target that moves over the bottom by itself, as on a crawler."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.camera import SAND, Camera, Window
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water
from seamark.sim.numerics.libm import sincos

Vector = NDArray[np.float64]

OWN = 12  # numbers of the vehicle in a pose, with its velocities; the target's follow
AWAY_M = 1000.0  # far outside any image


class TargetPath(Protocol):
    """Where a target is at any time of a level."""

    def place_and_rate(self, t: float) -> tuple[Sequence[float], Sequence[float]]:
        """Return north, east [m] and heading [rad], (3,), and how fast they change, (3,)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """A path of the target in the images of a level."""

    path: TargetPath
    first_frame: int  # of the level, in the trial
    image_period_s: float

    def at(self, frame: int) -> Vector:
        """Return north, east and heading in an image, and how fast they change, (6,)."""
        t = (frame - self.first_frame) * self.image_period_s
        return np.concatenate(self.path.place_and_rate(t))


class MovingTargetCamera(Camera):
    """`Camera` whose target is in another place in each frame.

    A pose is the vehicle's with its velocities, (12,), and then the target's north, east and
    heading and their rates, (18,): `at` adds them to the vehicle's. Without them the target is at
    the middle of its path.
    """

    def __init__(
        self,
        optics: Optics,
        water: Water,
        target: Target,
        *,
        noise_seed: int,
        effects: Effects | None = None,
        ground: str = SAND,
        course: Course,
    ) -> None:
        """Set up the camera of a level, in which the target is on this course."""
        super().__init__(
            optics, water, target, noise_seed=noise_seed, effects=effects, ground=ground
        )
        self._course = course
        self._size = np.array(target.size_m)
        self._home = np.array([target.north_m, target.east_m, target.heading_rad])
        self._place = np.empty(3)

    def at(self, motion: Vector, frame: int) -> Vector:
        """Return pose and velocity of the vehicle, (12,), with those of the target, (18,)."""
        return np.concatenate([motion[:OWN], self._course.at(frame)])

    def target_at(self, pose: Vector) -> Target:
        """Return the target where it is in the image of a pose."""
        if len(pose) <= OWN:
            return self.target
        north, east, heading = pose[OWN : OWN + 3].tolist()
        return replace(self.target, north_m=north, east_m=east, heading_rad=heading)

    def follow(self, pose: Vector) -> None:
        """Put the target where it is in the image of a pose."""
        self._place[:] = pose[OWN : OWN + 3] if len(pose) > OWN else self._home
        place(
            *(self._size, self._place, float(self.target.seabed_m)),
            *(self._faces, self._corners, self._points),
        )
        if self._has_effects:
            self._effect_parameters.drift[:2] = self._place[:2]
            self._effect_parameters.drift[2:] = pose[OWN + 3 :] if len(pose) > OWN else 0.0

    def truth(self, pose: Vector) -> list[float]:
        """Return what `Camera.truth` does, of where the target is in the image of the pose."""
        self.follow(pose)
        return super().truth(pose)

    def corners(self, pose: Vector) -> Vector:
        """Return what `Camera.corners` does, of where the target is in the image of the pose."""
        self.follow(pose)
        return super().corners(pose)

    def without_noise(self, pose: Vector, *, target: bool) -> NDArray[np.uint8]:
        """Return an image (H, W) as a camera without noise takes it, with the target or without."""
        shown = pose.copy()
        shown[OWN] += 0.0 if target else AWAY_M
        noisy = self._grain
        self._grain = noisy._replace(read_variance=0.0, shot_gain=0.0)
        try:
            return self.grey(shown, 0)
        finally:
            self._grain = noisy

    def _draw(
        self, pose: Vector, frame: int, window: Window, number: int, out: NDArray[np.uint8]
    ) -> None:
        self.follow(pose)
        super()._draw(pose[:OWN], frame, window, number, out)


@njit(cache=True, nogil=True, error_model="numpy")
def place(
    size: Vector, at: Vector, seabed_m: float, faces: Vector, corners: Vector, points: Vector
) -> None:
    """Write what `Target.faces`, `top_corners` and its points are for another place and heading.

    Once for each image: the methods of a new target take ten times as long, for the same bits.

    Parameters
    ----------
    size : (3,) [m]
        Length, width and height.
    at : (3,) [m, rad]
        North, east and heading.
    points : (6, 3) [m]
        The corners, the centre of the top face, the centre of the box.
    """
    s, c = sincos(at[2])
    right, down = np.array([-s, c, 0.0]), np.array([-c, -s, 0.0])
    drop = np.array([0.0, 0.0, size[2]])
    centre = np.array([at[0], at[1], seabed_m - size[2]])
    for i in range(3):
        a, b = 0.5 * size[0] * right[i], 0.5 * size[1] * down[i]
        corners[0, i] = centre[i] - a - b
        corners[1, i] = centre[i] + a - b
        corners[2, i] = centre[i] + a + b
        corners[3, i] = centre[i] - a + b
        long, short = size[0] * right[i], size[1] * down[i]
        _write(faces, 0, i, corners[0, i], long, short, -1.0 if i == 2 else 0.0)
        _write(faces, 1, i, corners[3, i], long, drop[i], down[i])
        _write(faces, 2, i, corners[1, i], -long, drop[i], -down[i])
        _write(faces, 3, i, corners[0, i], short, drop[i], -right[i])
        _write(faces, 4, i, corners[2, i], -short, drop[i], right[i])
        points[:4, i] = corners[:, i]
        points[4, i] = points[5, i] = centre[i]
    points[5, 2] = seabed_m - 0.5 * size[2]


@njit(cache=True, nogil=True, error_model="numpy")
def _write(
    faces: Vector, face: int, i: int, corner: float, first: float, second: float, normal: float
) -> None:
    faces[face, i], faces[face, 3 + i] = corner, first
    faces[face, 6 + i], faces[face, 9 + i] = second, normal
