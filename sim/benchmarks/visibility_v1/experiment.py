"""Visibility: trackers on images that degrade from level to level."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.benchmarks.visibility_v1.settings import VisibilityConfiguration
from seamark.sim.camera.camera import Camera
from seamark.sim.camera.target import start_pose
from seamark.sim.camera.water import Water
from seamark.sim.engine.closed_loop import ClosedLoop
from seamark.sim.engine.experiment import Level, TrialPlan, TrialScore
from seamark.sim.engine.level_current import level_current, level_stretch, site_of
from seamark.sim.engine.open_loop import OpenLoop
from seamark.sim.engine.prescribed_path import PrescribedPath
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.world import (
    Conditions,
    build_camera,
    build_tracking,
    build_world,
    configured_water,
    draw_noise_seed,
)
from seamark.sim.metrics.metric import over_run
from seamark.sim.metrics.tracking import METRICS, failure_value, held_value, level_metrics
from seamark.sim.numerics.libm import exp
from seamark.sim.numerics.random_streams import Streams, streams
from seamark.sim.physics.current import Pattern
from seamark.sim.recording.telemetry import Rows
from seamark.sim.trackers import Tracker

TILT_SHARE = 0.6  # amplitude of roll and pitch relative to that of the heading; E
LN_2 = 0.6931471805599453  # a stop is a factor of two
MAX_READ_NOISE_GREY = 64.0  # the maximum of `Water`
CONTROLLER = "pi"  # in closed loop, the same for all trackers
FAILED_AT_ONCE = "The tracker failed at the first level, in the clearest water."


class Visibility:
    """A `seamark.sim.engine.experiment.Experiment` that compares trackers."""

    def built_in(self, name: str, config: VisibilityConfiguration) -> None:
        """Return None: a level then uses the configured tracker."""

    def layout(self, config: VisibilityConfiguration) -> dict[str, Any]:
        """Return the role of programs."""
        return {"role": "tracker"}

    def plan(self, config: VisibilityConfiguration, *, seed: int, trial: int) -> TrialPlan:
        """Return that the levels run as listed, and which stretch of a record each has."""
        order = tuple(range(len(config.level_values())))
        site, told = site_of(config, 0.0), []
        for level in order if config.mode == "free" else ():
            random = streams(seed, trial, level)
            stretch = level_stretch(config, site, config.current_m_s, random)
            told.append(None if stretch is None else stretch._asdict())
        return TrialPlan(order=order, conditions={"stretches": told} if any(told) else {})

    def level(
        self,
        config: VisibilityConfiguration,
        solution: Tracker | None,
        *,
        seed: int,
        trial: int,
        level: int,
    ) -> Level:
        """Return a level with the vehicle, or the path, at its start."""
        random = streams(seed, trial, level)
        if config.mode == "free":
            world = build_world(
                config, _conditions(config, level, random), random, tracker=solution
            )
            return ClosedLoop(world, BuiltIn(CONTROLLER, config), trial=trial, level=level)
        noise_seed = draw_noise_seed(random)
        camera, reference = (
            build_camera(config, water_at(config, at), noise_seed=noise_seed) for at in (level, 0)
        )
        tracking = build_tracking(config, camera, random, tracker=solution, reference=reference)
        station = start_pose(camera.optics, camera.target, config.altitude_m)
        path = _path(config, station, random)
        return OpenLoop(config, path, camera, tracking, station=station, trial=trial, level=level)

    def camera(
        self, config: VisibilityConfiguration, *, seed: int, trial: int, level: int
    ) -> Camera:
        """Return the camera in the water of a level."""
        noise_seed = draw_noise_seed(streams(seed, trial, level))
        return build_camera(config, water_at(config, level), noise_seed=noise_seed)

    def first_camera(
        self, config: VisibilityConfiguration, *, seed: int, trial: int, level: int
    ) -> Camera:
        """Return the camera of a level in the water of the first one."""
        noise_seed = draw_noise_seed(streams(seed, trial, level))
        return build_camera(config, water_at(config, 0), noise_seed=noise_seed)

    def metrics(self, config: VisibilityConfiguration, level: int, rows: Rows) -> dict[str, Any]:
        """Return the tracking metrics of a level with its value."""
        position = {"level": level, "value": config.level_values()[level]}
        depth = {"optical_depth": config.optical_depths()[level]}
        return position | depth | level_metrics(rows)

    def trial_score(
        self, config: VisibilityConfiguration, levels: Sequence[Mapping[str, Any]]
    ) -> TrialScore:
        """Return the value of the first level at which the tracker fails.

        A tracker that fails at the first level cannot rank.
        """
        values = config.score_values()
        score = failure_value(values, [level["p5_percent"] for level in levels])
        return TrialScore(
            score=score,
            level_held=held_value(values, [level["held"] for level in levels]),
            rankable=math.isfinite(score) and score > values[0],
            reason=FAILED_AT_ONCE if score <= values[0] else "",
            overall=over_run(METRICS, levels),
        )


def _path(
    config: VisibilityConfiguration, station: NDArray[np.float64], random: Streams
) -> PrescribedPath:
    horizontal, heading = config.path_swing_m, config.path_turn_rad
    heave, tilt = config.path_heave_share * horizontal, TILT_SHARE * heading
    amplitudes = (horizontal, horizontal, heave, tilt, tilt, heading)
    return PrescribedPath(
        station.tolist(), amplitudes, period_s=config.path_period_s, random=random.scene
    )


def _conditions(config: VisibilityConfiguration, level: int, random: Streams) -> Conditions:
    pattern = Pattern()
    site = site_of(config, pattern.azimuth_rad)
    current = level_current(config, site, config.current_m_s, random, pattern=pattern)
    water, reference = (water_at(config, at) for at in (level, 0))
    return Conditions(current=current, water=water, reference=reference)


def water_at(config: VisibilityConfiguration, level: int) -> Water:
    """Return the water of a level."""
    water, value = configured_water(config), config.level_values()[level]
    if config.sweep == "camera_noise":
        return replace(water, read_sigma_grey=value)
    if config.sweep == "light":  # the camera's gain compensates for it and amplifies the noise
        gain = exp(value * LN_2)
        sigma, shot = gain * water.read_sigma_grey, gain * water.shot_gain
        return replace(water, read_sigma_grey=min(sigma, MAX_READ_NOISE_GREY), shot_gain=shot)
    if config.sweep == "fog":
        attenuation = value
    elif config.water_law == "uwsim":  # its optical depth is (density times distance) squared
        attenuation = math.sqrt(value) / config.altitude_m
    else:
        attenuation = value / config.altitude_m
    return replace(water, attenuation=(attenuation,) * 3)


EXPERIMENT = Visibility()
