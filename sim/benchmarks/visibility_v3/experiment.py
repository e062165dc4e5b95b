"""Visibility on three axes, above a target that moves over the bottom."""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from seamark.sim.benchmarks.visibility_v2 import experiment as second
from seamark.sim.benchmarks.visibility_v2.settings import JUMP, MOTION, TURBIDITY
from seamark.sim.benchmarks.visibility_v3.jumps import Jumps
from seamark.sim.benchmarks.visibility_v3.reference import IdealObserver, SilentTracker, Truth
from seamark.sim.benchmarks.visibility_v3.scenario import Motion, camera_of, draw_scenario
from seamark.sim.benchmarks.visibility_v3.settings import VisibilityConfiguration
from seamark.sim.benchmarks.visibility_v3.whole_image import WholeImageFilter, WholeImageMatch
from seamark.sim.camera.moving_target import MovingTargetCamera
from seamark.sim.engine.experiment import Level
from seamark.sim.metrics.tracking_answers import METRICS, NET, WRONG_COST
from seamark.sim.trackers import Tracker


class Visibility(second.Visibility[VisibilityConfiguration]):
    """A `seamark.sim.engine.experiment.Experiment` that compares trackers."""

    metrics_of_levels = METRICS
    quality = NET.name
    wrong_cost = WRONG_COST

    def built_in(self, name: str, config: VisibilityConfiguration) -> Any:
        """Return a reference entry, or None: a level then uses the configured tracker."""
        if name in _REFERENCE:
            return _REFERENCE[name]()
        if name == Truth.IDEAL.value:
            return Truth.IDEAL
        return super().built_in(name, config)

    def conditions(
        self, config: VisibilityConfiguration, *, seed: int, trial: int
    ) -> dict[str, Any]:
        """Return what was drawn for a trial, as JSON values."""
        return draw_scenario(config, seed, trial).as_dict()

    def level(
        self,
        config: VisibilityConfiguration,
        solution: Any,  # a tracker, a truth, or None for the configured tracker
        *,
        seed: int,
        trial: int,
        level: int,
    ) -> Level:
        """Return a level at the start of its path, or before its first jump."""
        if solution is Truth.IDEAL:
            solution = _ideal(config, seed=seed, trial=trial, level=level)
        return super().level(config, solution, seed=seed, trial=trial, level=level)

    def path(
        self, config: VisibilityConfiguration, *, seed: int, trial: int, level: int
    ) -> Motion | Jumps:
        """Return where the vehicle is at any time of a level, and the target."""
        return _path(config, seed, trial, level)

    def camera(
        self, config: VisibilityConfiguration, *, seed: int, trial: int, level: int
    ) -> MovingTargetCamera:
        """Return the camera in the water of a level."""
        listed = config.listed()[level]
        depths = {TURBIDITY: listed.value, MOTION: config.motion_depth, JUMP: 0.0}
        return _camera(config, depths[listed.axis], seed=seed, trial=trial, level=level)

    def first_camera(
        self, config: VisibilityConfiguration, *, seed: int, trial: int, level: int
    ) -> MovingTargetCamera:
        """Return the camera in clear water: every level begins with an image of it."""
        return _camera(config, 0.0, seed=seed, trial=trial, level=level, still=True)


def _camera(
    config: VisibilityConfiguration,
    depth: float,
    *,
    seed: int,
    trial: int,
    level: int,
    still: bool = False,
) -> MovingTargetCamera:
    blurred = config.listed()[level].axis is MOTION and not still
    return camera_of(
        draw_scenario(config, seed, trial).scene,
        config,
        depth,
        _path(config, seed, trial, level),
        first_frame=level * config.control_steps_per_level,
        exposure_s=config.motion_exposure_s if blurred else 0.0,
    )


@lru_cache(maxsize=64)  # camera and level ask for the same; jumps take a moment to draw
def _path(config: VisibilityConfiguration, seed: int, trial: int, level: int) -> Motion | Jumps:
    scenario, listed = draw_scenario(config, seed, trial), config.listed()[level]
    if listed.axis is JUMP:
        return Jumps(config, scenario, listed.value, level=level)
    if listed.axis is TURBIDITY:
        return scenario.turbid.at(scenario.scene.turbid_motion_px, config.control_period_s)
    return scenario.fast.at(listed.value, config.control_period_s)


def _ideal(config: VisibilityConfiguration, *, seed: int, trial: int, level: int) -> IdealObserver:
    listed = config.listed()[level]
    camera = EXPERIMENT.camera(config, seed=seed, trial=trial, level=level)
    path, first = _path(config, seed, trial, level), level * config.control_steps_per_level

    def pose(image: int) -> np.ndarray[Any, np.dtype[np.float64]]:
        own = np.concatenate(path.pose_and_velocity(image * config.control_period_s))
        return camera.at(own, first + image)

    turbid_px = draw_scenario(config, seed, trial).scene.turbid_motion_px
    return IdealObserver(
        camera,
        _camera(config, 0.0, seed=seed, trial=trial, level=level),
        pose,
        motion_px=turbid_px if listed.axis is TURBIDITY else listed.value,
    )


_REFERENCE: Mapping[str, Callable[[], Tracker]] = {
    "silent": SilentTracker,
    "whole-image-match": WholeImageMatch,
    "whole-image-filter": WholeImageFilter,
}
EXPERIMENT = Visibility()
