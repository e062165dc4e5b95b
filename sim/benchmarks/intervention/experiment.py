"""Interventions: a vehicle with an arm works on something, in a current that a level sets."""

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Generic, TypeVar

from seamark.sim.benchmarks.in_current import InCurrent
from seamark.sim.benchmarks.level_area import area_over_current, held_up_to
from seamark.sim.camera.water import Water
from seamark.sim.engine.experiment import TrialPlan, TrialScore
from seamark.sim.metrics.attempts import StagedAttempt
from seamark.sim.metrics.metric import LevelMetric, compute_all, over_run
from seamark.sim.numerics.random_streams import streams
from seamark.sim.recording.telemetry import ARM_JOINTS, Rows
from seamark.sim.settings.intervention import InterventionSettings

Settings = TypeVar("Settings", bound=InterventionSettings)
DONE_CREDIT = 0.999  # from which an attempt counts as done
TRIED_CREDIT = 0.1  # of a program that got its hand to the work


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """How far camera and arm are from what programs are told."""

    focal_factor: float
    encoder_bias_rad: tuple[float, ...]


class Intervention(InCurrent[Settings], Generic[Settings]):
    """A `seamark.sim.engine.experiment.Experiment` whose score is an area under stage credit.

    `metrics` are those of a level; one of them is named credit.
    """

    # why a trial does not rank whose program has not tried
    not_tried = "The arm did not get to its work in either of the two weakest currents."

    def __init__(self, metrics: tuple[LevelMetric[Any], ...]) -> None:
        self._metrics = metrics

    @abstractmethod
    def attempt(self, config: Settings, rows: Rows) -> StagedAttempt:
        """Return the rows of a level for its metrics."""

    @abstractmethod
    def drawn_work(self, config: Settings, *, seed: int, trial: int) -> Mapping[str, Any]:
        """Return what is drawn of the work for a trial, as plain JSON values."""

    def at(self, config: Settings, *, seed: int, trial: int, level: int) -> Settings:
        """Return the settings of a level, with the true focal length of the trial's camera."""
        here = super().at(config, seed=seed, trial=trial, level=level)
        factor = self.calibration(config, seed=seed, trial=trial).focal_factor
        return here.model_copy(update={"camera_focal_px": here.camera_focal_px * factor})

    def water(self, config: Settings, *, seed: int, trial: int) -> Water:
        """Return the water of the settings with the suspended matter of the trial."""
        clear = super().water(config, seed=seed, trial=trial)
        more = self.turbidity(config, seed=seed, trial=trial) / config.altitude_m
        red, green, blue = (one + more for one in clear.attenuation)
        return replace(clear, attenuation=(red, green, blue))

    def turbidity(self, config: Settings, *, seed: int, trial: int) -> float:
        """Return the optical depth of suspended matter, from the camera at the start."""
        return config.turbidity_spread * float(streams(seed, trial, 0).trial_water.random())

    def encoder_bias(self, config: Settings, *, seed: int, trial: int) -> tuple[float, ...]:
        """Return the constant error of each joint of the arm [rad]."""
        return self.calibration(config, seed=seed, trial=trial).encoder_bias_rad

    def calibration(self, config: Settings, *, seed: int, trial: int) -> Calibration:
        """Return the errors of camera and arm that nobody knows."""
        random = streams(seed, trial, 0).trial_calibration
        focal, *joints = random.uniform(-1.0, 1.0, 1 + ARM_JOINTS).tolist()
        return Calibration(
            focal_factor=1.0 + config.focal_spread * focal,
            encoder_bias_rad=tuple(
                config.encoder_bias_rad * one for one in joints[: len(config.the_arm().motors())]
            ),
        )

    def plan(self, config: Settings, *, seed: int, trial: int) -> TrialPlan:
        """Return the order of a trial's levels and all that was drawn for it."""
        drawn = self.drawn(config, seed=seed, trial=trial)
        work = self.drawn_work(config, seed=seed, trial=trial)
        calibration = self.calibration(config, seed=seed, trial=trial)
        conditions = drawn.as_dict() | {
            "work": dict(work),
            "calibration": asdict(calibration),
            "turbidity": self.turbidity(config, seed=seed, trial=trial),
        }
        stretches = self.stretches(config, seed=seed, trial=trial)
        return TrialPlan(order=drawn.order, conditions=conditions | stretches)

    def metrics(self, config: Settings, level: int, rows: Rows) -> dict[str, Any]:
        """Return the metrics of a level."""
        grid = config.grid_point(level)
        values = compute_all(self._metrics, self.attempt(config, rows))
        done = float(values["credit"] or 0.0) >= DONE_CREDIT
        speed = config.level_values()[level]
        whole = {"level": level, "speed": speed, "held": done} | values
        return whole | ({"grid": grid} if grid else {})

    def trial_score(self, config: Settings, levels: Sequence[Mapping[str, Any]]) -> TrialScore:
        """Return the area under the credit over the current [m/s]."""
        score = area_over_current(levels, "credit")
        weakest = sorted(levels, key=lambda level: float(level["speed"]))[:2]
        tried = any(level["credit"] >= TRIED_CREDIT for level in weakest)
        return TrialScore(
            score=score,
            level_held=held_up_to(levels),
            rankable=math.isfinite(score) and tried,
            reason="" if tried else self.not_tried,
            overall=over_run(self._metrics, levels),
        )
