"""Station keeping: a vehicle in closed loop above the target, in a current that a level sets."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Generic, TypeVar

from seamark.sim.camera.camera import Camera
from seamark.sim.camera.target import start_pose
from seamark.sim.control.observation import arm_size, layout
from seamark.sim.engine.closed_loop import ClosedLoop
from seamark.sim.engine.experiment import TrialPlan, TrialScore
from seamark.sim.engine.program import BuiltIn, Program
from seamark.sim.engine.trial_conditions import NOMINAL, TrialConditions
from seamark.sim.engine.world import (
    Conditions,
    Craft,
    World,
    build_camera,
    build_craft,
    build_world,
    configured_water,
    draw_noise_seed,
    program_optics,
    target_and_optics,
)
from seamark.sim.metrics.metric import Absent, LevelMetric, over_run
from seamark.sim.metrics.station_keeping import METRICS, level_metrics, overall
from seamark.sim.metrics.windows import LevelFacts, Window
from seamark.sim.numerics.random_streams import Streams, streams
from seamark.sim.numerics.statistics import mean
from seamark.sim.physics.current import Current, Pattern, Shear
from seamark.sim.recording.telemetry import Rows
from seamark.sim.settings.station_keeping import StationKeepingSettings
from seamark.sim.vehicles import load

LOST = "The target was lost throughout a level."
Settings = TypeVar("Settings", bound=StationKeepingSettings)


class StationKeeping(Generic[Settings]):
    """A `seamark.sim.engine.experiment.Experiment` that compares position controllers.

    `further` are metrics that it computes beside those of every station-keeping benchmark.
    """

    def __init__(self, further: tuple[LevelMetric[Window], ...] = ()) -> None:
        self._metrics = (*METRICS, *further)

    def built_in(self, name: str, config: Settings) -> Program:
        """Return a built-in controller."""
        arm = config.chosen_arm()
        return BuiltIn(name, config, None if arm is None else arm_size(arm))

    def layout(self, config: Settings) -> dict[str, Any]:
        """Return the order of observation and command."""
        optics = program_optics(config)
        images = {camera: (each.height, each.width) for camera, each in optics.items()}
        return {"role": "controller"} | layout(config.vehicle, config.chosen_arm(), images)

    def drawn(self, config: Settings, *, seed: int, trial: int) -> TrialConditions:
        """Return the conditions of a trial: nominal, unless overridden."""
        return NOMINAL

    def plan(self, config: Settings, *, seed: int, trial: int) -> TrialPlan:
        """Return that the levels run as listed."""
        return TrialPlan(order=tuple(range(len(config.level_values()))))

    def level(
        self,
        config: Settings,
        solution: Program,
        *,
        seed: int,
        trial: int,
        level: int,
    ) -> ClosedLoop:
        """Return a level with the vehicle at its start."""
        world = self.world(config, seed=seed, trial=trial, level=level)
        order = self.plan(config, seed=seed, trial=trial).order
        return ClosedLoop(world, solution, trial=trial, level=level, position=order.index(level))

    def tool_m(self, config: Settings) -> tuple[float, float] | None:
        """Return the point of the body, forward and starboard [m], that counts; None: the pose."""
        return None

    def world(self, config: Settings, *, seed: int, trial: int, level: int) -> World:
        """Return the world of a level."""
        config, random = config.for_trial(trial).at(level), streams(seed, trial, level)
        drawn = self.drawn(config, seed=seed, trial=trial)
        return build_world(config, self._conditions(config, level, drawn, random), random)

    def craft(self, config: Settings, *, seed: int, trial: int, level: int) -> Craft:
        """Return the world of a level without its camera, at a fraction of the cost."""
        config, random = config.for_trial(trial).at(level), streams(seed, trial, level)
        drawn = self.drawn(config, seed=seed, trial=trial)
        return build_craft(config, self._conditions(config, level, drawn, random), random)

    def _conditions(
        self, config: Settings, level: int, drawn: TrialConditions, random: Streams
    ) -> Conditions:
        return Conditions(
            current=_current(config, level, drawn, random),
            water=configured_water(config),
            trial=drawn,
            tool_m=self.tool_m(config),
        )

    def camera(self, config: Settings, *, seed: int, trial: int, level: int) -> Camera:
        """Return the camera of a level."""
        config = config.at(level)
        noise_seed = draw_noise_seed(streams(seed, trial, level))
        return build_camera(config, configured_water(config), noise_seed=noise_seed)

    def first_camera(self, config: Settings, *, seed: int, trial: int, level: int) -> Camera:
        """Return the camera of the level: all its images show the same water."""
        return self.camera(config, seed=seed, trial=trial, level=level)

    def metrics(
        self, config: Settings, level: int, rows: Rows, *, absent: Absent = frozenset()
    ) -> dict[str, Any]:
        """Return the metrics of a level, and its coordinates if there is a grid."""
        grid = config.grid_point(level)
        metrics = level_metrics(rows, level_facts(config, level, absent), self._metrics)
        return metrics | ({"grid": grid} if grid else {})

    def trial_score(self, config: Settings, levels: Sequence[Mapping[str, Any]]) -> TrialScore:
        """Return the mean of the levels' points, 0 to 100.

        A trial can rank if that is finite and the target was not lost throughout any level.
        """
        score = mean([float(level["points"]) for level in levels])
        all_lost = any(level["whole_lost_percent"] >= 100.0 for level in levels)
        return TrialScore(
            score=score,
            level_held=_held(levels),
            rankable=math.isfinite(score) and not all_lost,
            reason=LOST if all_lost else "",
            overall=over_run(self.overall_metrics(), levels),
        )

    def overall_metrics(self) -> tuple[LevelMetric[Any], ...]:
        """Return the metrics over all levels of a trial."""
        return overall(self._metrics)


def _held(levels: Sequence[Mapping[str, Any]]) -> float | None:
    """Return the speed [m/s] up to which every level was held; None if not even the lowest."""
    held: float | None = None
    for speed in sorted({float(level["speed"]) for level in levels}):
        if not all(level["held"] for level in levels if level["speed"] == speed):
            break
        held = speed
    return held


def level_facts(
    config: StationKeepingSettings, level: int, absent: Absent = frozenset()
) -> LevelFacts:
    """Return what the metrics of a level need beside its telemetry."""
    vehicle = load(config.vehicle)
    forward, reverse = vehicle.curve.limits.value
    return LevelFacts(
        level=level,
        speed=config.level_values()[level],
        dt=config.control_period_s,
        settle_s=config.settle_s,
        limits_n=(forward, reverse),
        thrusters=len(vehicle.thrusters),
        absent=absent,
    )


def _current(
    config: StationKeepingSettings, level: int, drawn: TrialConditions, random: Streams
) -> Current:
    pattern = Pattern(
        azimuth_rad=config.current_azimuth_rad,
        azimuth_swing_rad=config.current_swing_rad,
        azimuth_period_s=config.current_swing_period_s,
        speed_swing=config.current_wave_m_s,
        speed_period_s=config.current_wave_period_s,
        gust_share=config.current_gust,
        gust_time_s=config.current_gust_time_s,
        law="force" if config.current_law == "force" else "relative",
        force_share=config.current_force_share,
    )
    return Current(
        config.level_values()[level],
        pattern=drawn.current.of(pattern),
        shear=_shear(config),
        rng=random.gust,
        duration_s=config.level_duration_s,
    )


def _shear(config: StationKeepingSettings) -> Shear | None:
    """Return the current's profile: at the height of the start the level's own speed."""
    if not config.current_shear:
        return None
    target, optics = target_and_optics(config)
    start = float(start_pose(optics, target, config.altitude_m)[2])
    bottom = target.seabed_m
    return Shear(exponent=config.current_shear, bottom_m=bottom, height_m=bottom - start)


EXPERIMENT: StationKeeping[StationKeepingSettings] = StationKeeping()
