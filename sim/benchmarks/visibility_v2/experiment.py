"""Visibility on three axes: turbidity, motion, and single jumps."""

from collections.abc import Mapping, Sequence
from typing import Any, Generic, TypeVar

import numpy as np

from seamark.sim.benchmarks.visibility_v2.jumps import Jumps
from seamark.sim.benchmarks.visibility_v2.reference import BlindTracker, StillTracker, Truth
from seamark.sim.benchmarks.visibility_v2.scenario import Scenario, draw_scenario
from seamark.sim.benchmarks.visibility_v2.settings import (
    JUMP,
    MOTION,
    TURBIDITY,
    Axis,
    AxisLevel,
    VisibilityConfiguration,
)
from seamark.sim.camera.camera import Camera
from seamark.sim.engine.experiment import Level, TrialPlan, TrialScore
from seamark.sim.engine.open_loop import OpenLoop, Path
from seamark.sim.engine.tracker_in_loop import TrackerInLoop, draw_start_error
from seamark.sim.metrics.metric import LevelMetric, over_run
from seamark.sim.metrics.tracking import FAILED_PERCENT, P1, P5, Images, held_value
from seamark.sim.metrics.tracking_losses import METRICS, followed_metrics, jump_metrics
from seamark.sim.numerics.random_streams import streams
from seamark.sim.numerics.statistics import area
from seamark.sim.recording.telemetry import Rows
from seamark.sim.registry import TRUTH
from seamark.sim.trackers import Tracker, make

CLEAR_WATER = "The tracker does not follow the target in the clearest water (p@5 below 50 %)."


Configured = TypeVar("Configured", bound=VisibilityConfiguration)


class Visibility(Generic[Configured]):
    """A `seamark.sim.engine.experiment.Experiment` that compares trackers."""

    metrics_of_levels: Sequence[LevelMetric[Images]] = METRICS
    quality: str = P5.name  # of a level [%]: the score is the area under it
    wrong_cost: float = 0.0  # of a wrong answer, if a right one counts 1

    def built_in(self, name: str, config: Configured) -> Tracker | Truth | None:
        """Return a reference entry, or None: a level then uses the configured tracker."""
        if name == "nothing":
            return StillTracker()
        if name == "blind":
            return BlindTracker(make(config.tracker, truth=None, **config.tracker_options()))
        return Truth.ORACLE if name == Truth.ORACLE.value else None

    def layout(self, config: Configured) -> dict[str, Any]:
        """Return the role of programs."""
        return {"role": "tracker"}

    def plan(self, config: Configured, *, seed: int, trial: int) -> TrialPlan:
        """Return that the levels run as listed, and what was drawn for the trial."""
        return TrialPlan(
            order=tuple(range(len(config.listed()))),
            conditions=self.conditions(config, seed=seed, trial=trial),
        )

    def conditions(self, config: Configured, *, seed: int, trial: int) -> dict[str, Any]:
        """Return what was drawn for a trial, as JSON values."""
        return draw_scenario(config, seed, trial).as_dict()

    def level(
        self,
        config: Configured,
        solution: Tracker | Truth | None,
        *,
        seed: int,
        trial: int,
        level: int,
    ) -> Level:
        """Return a level at the start of its path, or before its first jump."""
        camera = self.camera(config, seed=seed, trial=trial, level=level)
        oracle = isinstance(solution, Truth)
        tracking = TrackerInLoop(
            camera,
            config.model_copy(update={"tracker": TRUTH}) if oracle else config,
            draw_start_error(config.start_error_px, streams(seed, trial, level)),
            tracker=None if isinstance(solution, Truth) else solution,
            reference=self.first_camera(config, seed=seed, trial=trial, level=level),
        )
        return OpenLoop(
            config,
            self.path(config, seed=seed, trial=trial, level=level),
            camera,
            tracking,
            station=np.array(draw_scenario(config, seed, trial).station),
            trial=trial,
            level=level,
            start_every=config.images_per_start(level),
        )

    def path(self, config: Configured, *, seed: int, trial: int, level: int) -> Path:
        """Return where the vehicle is at any time of a level."""
        scenario, listed = draw_scenario(config, seed, trial), config.listed()[level]
        return _path(config, scenario, listed, _camera(config, scenario, listed), level)

    def camera(self, config: Configured, *, seed: int, trial: int, level: int) -> Camera:
        """Return the camera in the water of a level."""
        return _camera(config, draw_scenario(config, seed, trial), config.listed()[level])

    def first_camera(self, config: Configured, *, seed: int, trial: int, level: int) -> Camera:
        """Return the camera in clear water: every level begins with an image of it."""
        return _clear(config, draw_scenario(config, seed, trial))

    def metrics(self, config: Configured, level: int, rows: Rows) -> dict[str, Any]:
        """Return the metrics of a level with its axis and value."""
        listed = config.listed()[level]
        position = {"level": level, "axis": listed.axis.name, "value": listed.value}
        measure = jump_metrics if listed.axis is JUMP else followed_metrics
        measured = measure(rows, self.metrics_of_levels)
        return position | {"name": listed.name} | measured

    def trial_score(self, config: Configured, levels: Sequence[Mapping[str, Any]]) -> TrialScore:
        """Return the area under the quality over the optical depth, and those of the other axes.

        A tracker that fails in the clearest water cannot rank.
        """
        turbid = [levels[index] for index in config.levels_of(TURBIDITY)]
        clearest = min(turbid, key=lambda level: float(level["value"]))
        rankable = clearest[P5.name] >= FAILED_PERCENT
        rising = sorted(turbid, key=lambda level: float(level["value"]))
        depths, shares = _points(config, levels, TURBIDITY, self.quality)
        return TrialScore(
            score=area(depths, shares),
            level_held=held_value(
                [level["value"] for level in rising], [level["held"] for level in rising]
            ),
            rankable=rankable,
            reason="" if rankable else CLEAR_WATER,
            overall={
                "motion_held_px": _area_from_zero(*_points(config, levels, MOTION, self.quality)),
                "basin_px": _area_from_zero(*_points(config, levels, JUMP, P1.name), at_zero=1.0),
                **over_run(self.metrics_of_levels, turbid),
            },
        )


def _clear(config: VisibilityConfiguration, scenario: Scenario) -> Camera:
    return scenario.camera(0.0, config.altitude_m)


def _camera(config: VisibilityConfiguration, scenario: Scenario, listed: AxisLevel) -> Camera:
    if listed.axis is TURBIDITY:
        return scenario.camera(listed.value, config.altitude_m)
    if listed.axis is MOTION:
        exposure_s = config.motion_exposure_s
        return scenario.camera(config.motion_depth, config.altitude_m, exposure_s=exposure_s)
    return _clear(config, scenario)


def _path(
    config: VisibilityConfiguration,
    scenario: Scenario,
    listed: AxisLevel,
    camera: Camera,
    level: int,
) -> Path:
    if listed.axis is JUMP:
        return Jumps(
            scenario,
            camera,
            listed.value,
            level=level,
            count=config.control_steps_per_level // config.images_per_start(level),
            image_period_s=config.control_period_s,
        )
    if listed.axis is TURBIDITY:
        return scenario.turbid.at(scenario.turbid_motion_px, config.control_period_s)
    return scenario.fast.at(listed.value, config.control_period_s)


def _points(
    config: VisibilityConfiguration, levels: Sequence[Mapping[str, Any]], axis: Axis, metric: str
) -> tuple[list[float], list[float]]:
    """Return the values of the levels of an axis, and a metric [%] as shares from 0 to 1."""
    chosen = [levels[index] for index in config.levels_of(axis)]
    return [level["value"] for level in chosen], [0.01 * level[metric] for level in chosen]


def _area_from_zero(
    values: Sequence[float], shares: Sequence[float], *, at_zero: float | None = None
) -> float:
    """Return the area from 0 on; without a share at 0, the first level's holds down to it."""
    first = min(zip(values, shares, strict=True))[1] if at_zero is None else at_zero
    return area([0.0, *values], [first, *shares])


EXPERIMENT = Visibility[VisibilityConfiguration]()
