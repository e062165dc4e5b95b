"""What is drawn for one trial of visibility-v3: the scene of visibility-v2, and pairs of paths.

The vehicle moves, and the target moves over the bottom by itself, as an object does that a crawler
carries: north, east and heading, on its own phases and periods. So the motion of the bottom in the
image says where the vehicle is, and not where the target is. E: the ranges are estimates.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from seamark.sim.benchmarks.visibility_v2 import scenario as second
from seamark.sim.benchmarks.visibility_v2.scenario import (
    OPTICS,
    SAMPLED_S,
    SAMPLES,
    SEEDS,
    SHARE_OF_AMPLITUDE,
    around_one,
    displacement,
)
from seamark.sim.benchmarks.visibility_v3.settings import VisibilityConfiguration
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.moving_target import Course, MovingTargetCamera, TargetPath
from seamark.sim.engine.prescribed_path import PrescribedPath
from seamark.sim.numerics.libm import sincos
from seamark.sim.numerics.statistics import mean

Numbers = tuple[float, ...]


class Motion:
    """Where vehicle and target are at any time."""

    def __init__(self, vehicle: PrescribedPath, target: PrescribedPath) -> None:
        self._vehicle, self._target = vehicle, target

    def pose_and_velocity(self, t: float) -> tuple[list[float], list[float]]:
        """Return the vehicle's pose (6) [m, rad], world frame, and velocity (6), body frame."""
        return self._vehicle.pose_and_velocity(t)

    def place_and_rate(self, t: float) -> tuple[list[float], list[float]]:
        """Return the target's north, east [m] and heading [rad], and how fast they change."""
        pose, velocity = self._target.pose_and_velocity(t)
        s, c = sincos(pose[5])
        ahead, aside = velocity[:2]
        return [*pose[:2], pose[5]], [c * ahead - s * aside, s * ahead + c * aside, velocity[5]]


@dataclass(frozen=True, slots=True)
class Shape:
    """The paths of vehicle and target without their speed, which both have in common."""

    vehicle: second.Shape
    home: Numbers  # (3,) of the target: north, east [m], heading [rad]
    reach: Numbers  # (3,) its amplitudes
    seed: int  # of its path
    speed_px: float  # [px/s] of the corners in the image, for a nominal period of 1 s

    def at(self, motion_px: float, image_period_s: float) -> Motion:
        """Return the paths on which the corners move so far [px] between images, on average."""
        return _motion(self, self.speed_px * image_period_s / motion_px)


def _motion(shape: Shape, period_s: float) -> Motion:
    vehicle, (north, east, heading), (swing, sway, turn) = shape.vehicle, shape.home, shape.reach
    return Motion(
        _path(vehicle.centre, vehicle.amplitudes, vehicle.seed, period_s),
        _path(
            (north, east, 0.0, 0.0, 0.0, heading),
            (swing, sway, 0.0, 0.0, 0.0, turn),
            shape.seed,
            period_s,
        ),
    )


def _path(
    centre: Sequence[float], amplitudes: Sequence[float], seed: int, period_s: float
) -> PrescribedPath:
    random = np.random.Generator(np.random.PCG64(seed))
    return PrescribedPath(centre, amplitudes, period_s=period_s, random=random)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """The conditions of a trial."""

    scene: second.Scenario  # target, bottom, water, light and jumps
    turbid: Shape  # of the levels of the turbidity axis
    fast: Shape  # of the levels of the motion axis

    def as_dict(self) -> dict[str, Any]:
        """Return what differs between trials, as JSON values."""
        own = {"target_swing_m": self.turbid.reach[0], "target_turn_rad": self.turbid.reach[2]}
        return self.scene.as_dict() | own


def camera_of(
    scene: second.Scenario,
    config: VisibilityConfiguration,
    optical_depth: float,
    path: TargetPath,
    *,
    first_frame: int = 0,
    exposure_s: float = 0.0,
) -> MovingTargetCamera:
    """Return the camera in water of an optical depth from the station to the target."""
    return MovingTargetCamera(
        OPTICS,
        scene.water_at(optical_depth, config.altitude_m),
        scene.target,
        noise_seed=scene.noise_seed,
        effects=Effects(exposure_s=exposure_s),
        ground=scene.ground,
        course=Course(path=path, first_frame=first_frame, image_period_s=config.control_period_s),
    )


@lru_cache(maxsize=4)
def draw_scenario(config: VisibilityConfiguration, seed: int, trial: int) -> Scenario:
    """Return the conditions of a trial, which depend on these values only."""
    scene = second.draw_scenario(config, seed, trial)
    random = np.random.Generator(np.random.PCG64([scene.turbid.seed, scene.fast.seed]))
    shares = random.random(4).tolist()
    seeds = random.integers(SEEDS, size=2).tolist()
    return Scenario(
        scene=scene,
        turbid=_shape(config, scene, scene.turbid, shares[:2], seeds[0]),
        fast=_shape(config, scene, scene.fast, shares[2:], seeds[1]),
    )


def _shape(
    config: VisibilityConfiguration,
    scene: second.Scenario,
    vehicle: second.Shape,
    shares: Sequence[float],
    seed: int,
) -> Shape:
    """Return the paths with their speed: mean root mean square displacement of the corners."""
    target = scene.target
    swing = config.target_swing_m * around_one(SHARE_OF_AMPLITUDE, shares[0])
    turn = config.target_turn_rad * around_one(SHARE_OF_AMPLITUDE, shares[1])
    home, reach = (target.north_m, target.east_m, target.heading_rad), (swing, swing, turn)
    motion = _motion(Shape(vehicle, home, reach, seed, 1.0), 1.0)
    camera = camera_of(scene, config, 0.0, motion)
    step_s = SAMPLED_S / SAMPLES
    corners = [seen(camera, motion, k * step_s) for k in range(SAMPLES + 1)]
    moved = mean([displacement(a, b) for a, b in pairwise(corners)])
    return Shape(vehicle, home, reach, seed, moved / step_s)


def seen(camera: MovingTargetCamera, motion: Motion, t: float) -> list[float]:
    """Return the target's corners (8,) [px] in the image at a time."""
    pose = np.concatenate([*motion.pose_and_velocity(t), *motion.place_and_rate(t)])
    corners: list[float] = camera.corners(pose).ravel().tolist()
    return corners
