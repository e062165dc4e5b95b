"""A vehicle in closed loop above a target, in a current that a level sets: how its levels run."""

from typing import Any, Generic, TypeVar

from seamark.sim.camera.bottom.painter import Tiles
from seamark.sim.camera.camera import Camera
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water
from seamark.sim.control.observation import arm_size, layout
from seamark.sim.engine.closed_loop import ClosedLoop
from seamark.sim.engine.dock_in_loop import Dock
from seamark.sim.engine.experiment import TrialPlan
from seamark.sim.engine.level_current import level_current, level_stretch, site_of
from seamark.sim.engine.program import BuiltIn, Program
from seamark.sim.engine.route_in_loop import Course
from seamark.sim.engine.team import Team
from seamark.sim.engine.trial_conditions import NOMINAL, TrialConditions, draw_conditions
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
)
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.random_streams import Streams, streams
from seamark.sim.physics.current import Current, Pattern
from seamark.sim.settings.current_levels import CurrentLevels
from seamark.sim.settings.trial_spreads import TrialSpreadSettings
from seamark.sim.vehicles import load

Settings = TypeVar("Settings", bound=CurrentLevels)


class InCurrent(Generic[Settings]):
    """The part of a `seamark.sim.engine.experiment.Experiment` that does not score."""

    task = ""  # by which the registry has the built-in controllers; "": to keep station

    def built_in(self, name: str, config: Settings) -> Program:
        """Return a built-in controller."""
        arm = config.chosen_arm()
        size = arm_size(arm) if arm else None
        return BuiltIn(name, config, size, task=self.task, **config.told())

    def layout(self, config: Settings) -> dict[str, Any]:
        """Return the order of observation and command."""
        optics = program_optics(config)
        images = {camera: (each.height, each.width) for camera, each in optics.items()}
        packed = layout(config.vehicle, config.chosen_arm(), images, **config.told())
        return {"role": "controller"} | packed

    def drawn(self, config: Settings, *, seed: int, trial: int) -> TrialConditions:
        """Return the conditions of a trial: nominal if the settings have nothing to spread."""
        own = config.for_trial(trial)
        if not isinstance(own, TrialSpreadSettings):
            return NOMINAL
        return draw_conditions(
            own,
            streams(seed, trial, 0),
            thrusters=len(load(own.vehicle).thrusters),
            levels=len(own.level_values()),
        )

    def plan(self, config: Settings, *, seed: int, trial: int) -> TrialPlan:
        """Return that the levels run as listed."""
        return TrialPlan(
            order=tuple(range(len(config.level_values()))),
            conditions=self.stretches(config, seed=seed, trial=trial),
        )

    def stretches(self, config: Settings, *, seed: int, trial: int) -> dict[str, Any]:
        """Return for the conditions which stretch of its record each level has; {} without one."""
        found = []
        for level, speed in enumerate(config.level_values()):
            here, random = config.for_trial(trial).at(level), streams(seed, trial, level)
            target = self.target(config, seed=seed, trial=trial)
            site = site_of(here, 0.0, target=target)
            found.append(level_stretch(here, site, speed, random))
        told = [None if stretch is None else stretch._asdict() for stretch in found]
        return {"stretches": told} if any(told) else {}

    def level(
        self,
        config: Settings,
        solution: Program | Team,
        *,
        seed: int,
        trial: int,
        level: int,
    ) -> ClosedLoop:
        """Return a level with the vehicle at its start."""
        team = solution if isinstance(solution, Team) else Team(solution)
        world = self.world(config, seed=seed, trial=trial, level=level, team=team)
        order = self.plan(config, seed=seed, trial=trial).order
        position = order.index(level)
        return ClosedLoop(world, team.controller, trial=trial, level=level, position=position)

    def tool_m(self, config: Settings) -> tuple[float, float] | None:
        """Return the point of the body, forward and starboard [m], that counts; None: the pose."""
        return None

    def at(self, config: Settings, *, seed: int, trial: int, level: int) -> Settings:
        """Return the settings of a level: those of its trial, with what a grid sets there."""
        return config.for_trial(trial).at(level)

    def target(self, config: Settings, *, seed: int, trial: int) -> Target | None:
        """Return the target, if it is not that of the settings."""
        return None

    def workpiece(self, config: Settings, *, seed: int, trial: int, level: int) -> Workpiece | None:
        """Return what the arm works on in a level; nothing, unless overridden."""
        return None

    def bottom(self, config: Settings, *, seed: int, trial: int, level: int) -> Tiles | None:
        """Return a painted seabed for a camera beside an arm, if it is not the plain one."""
        return None

    def course(self, config: Settings, *, seed: int, trial: int, level: int) -> Course | None:
        """Return what is to be followed in a level; nothing, unless overridden."""
        return None

    def dock(self, config: Settings, *, seed: int, trial: int, level: int) -> Dock | None:
        """Return what is to be entered in a level; nothing, unless overridden."""
        return None

    def water(self, config: Settings, *, seed: int, trial: int) -> Water:
        """Return the water of a level with these settings."""
        return configured_water(config)

    def encoder_bias(self, config: Settings, *, seed: int, trial: int) -> tuple[float, ...]:
        """Return the constant error of each joint of an arm, or of all [rad]; none."""
        return (0.0,)

    def world(
        self, config: Settings, *, seed: int, trial: int, level: int, team: Team | None = None
    ) -> World:
        """Return the world of a level, with the tracker and the detector of a team, if any."""
        conditions, random = self._conditions(config, seed=seed, trial=trial, level=level)
        config = self.at(config, seed=seed, trial=trial, level=level)
        tracker, detector = (team.tracker, team.detector) if team else (None, None)
        return build_world(config, conditions, random, tracker=tracker, detector=detector)

    def craft(self, config: Settings, *, seed: int, trial: int, level: int) -> Craft:
        """Return the world of a level without its camera, at a fraction of the cost."""
        conditions, random = self._conditions(config, seed=seed, trial=trial, level=level)
        config = self.at(config, seed=seed, trial=trial, level=level)
        return build_craft(config, conditions, random)

    def _conditions(
        self, config: Settings, *, seed: int, trial: int, level: int
    ) -> tuple[Conditions, Streams]:
        random = streams(seed, trial, level)
        drawn = self.drawn(config, seed=seed, trial=trial)
        here = self.at(config, seed=seed, trial=trial, level=level)
        target = self.target(config, seed=seed, trial=trial)
        conditions = Conditions(
            current=_current(here, level, drawn, random, target),
            water=self.water(here, seed=seed, trial=trial),
            trial=drawn,
            tool_m=self.tool_m(here),
            target=target,
            workpiece=self.workpiece(config, seed=seed, trial=trial, level=level),
            bottom=self.bottom(config, seed=seed, trial=trial, level=level),
            encoder_bias=self.encoder_bias(config, seed=seed, trial=trial),
            course=self.course(config, seed=seed, trial=trial, level=level),
            dock=self.dock(config, seed=seed, trial=trial, level=level),
        )
        return conditions, random

    def camera(
        self,
        config: Settings,
        *,
        seed: int,
        trial: int,
        level: int,
        optics: Optics | None = None,
    ) -> Camera:
        """Return the camera of a level; with other optics than its own if they are given."""
        here = self.at(config, seed=seed, trial=trial, level=level)
        course = self.course(config, seed=seed, trial=trial, level=level)
        return build_camera(
            here,
            self.water(here, seed=seed, trial=trial),
            noise_seed=draw_noise_seed(streams(seed, trial, level)),
            optics=optics,
            target=self.target(config, seed=seed, trial=trial),
            workpiece=self.workpiece(config, seed=seed, trial=trial, level=level),
            bottom=self.bottom(config, seed=seed, trial=trial, level=level),
            pipe=None if course is None else course.pipe,
            dock=self.dock(config, seed=seed, trial=trial, level=level),
        )

    def first_camera(self, config: Settings, *, seed: int, trial: int, level: int) -> Camera:
        """Return the camera of the level: all its images show the same water."""
        return self.camera(config, seed=seed, trial=trial, level=level)


def _current(
    config: CurrentLevels,
    level: int,
    drawn: TrialConditions,
    random: Streams,
    target: Target | None,
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
    pattern = drawn.current.of(pattern)
    return level_current(
        config,
        site_of(config, pattern.azimuth_rad, target=target),
        config.level_values()[level],
        random,
        pattern=pattern,
        exponent=config.current_shear,
    )
