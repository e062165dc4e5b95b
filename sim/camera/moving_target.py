"""The camera above a target that moves over the bottom by itself, as on a crawler."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.camera import SAND, Camera, Window
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water

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
        moved = self.target_at(pose)
        self._faces[:] = moved.faces()
        self._corners[:] = moved.top_corners()
        self._points[:4] = self._corners
        self._points[4], self._points[5] = moved.top_centre(), moved.origin()
        if self._effect_parameters is not None:
            self._effect_parameters.drift[:2] = moved.north_m, moved.east_m
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
