"""Following a route: how a level starts, and what it scores."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from seamark.sim.benchmarks.in_current import InCurrent
from seamark.sim.benchmarks.level_area import area_over_current, held_up_to
from seamark.sim.benchmarks.track_v1.routes import draw_route, lay_pipe
from seamark.sim.benchmarks.track_v1.settings import PIPE_RADIUS_M, SEABED_M, TrackConfiguration
from seamark.sim.camera.target import Target, start_pose
from seamark.sim.camera.water import Water
from seamark.sim.control.observation import PIPE
from seamark.sim.engine.experiment import TrialPlan, TrialScore
from seamark.sim.engine.route_in_loop import Course
from seamark.sim.engine.world import target_and_optics
from seamark.sim.metrics.following import METRICS, Following
from seamark.sim.metrics.metric import compute_all, over_run
from seamark.sim.metrics.tool_point import HELD_QUALITY
from seamark.sim.metrics.windows import LevelFacts
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import polar
from seamark.sim.numerics.polyline import starts_of
from seamark.sim.numerics.random_streams import streams
from seamark.sim.numerics.statistics import mean
from seamark.sim.recording.telemetry import Rows
from seamark.sim.sensors.usbl import Noise
from seamark.sim.vehicles import load

WEAK_LEVELS = 2  # number of weakest currents in which a program must follow the route to rank
RANKED_PERCENT = 50.0  # of the route, on average over them; E
NOT_FOLLOWED = (
    f"In the {WEAK_LEVELS} weakest currents of a trial, the vehicle did not get on along "
    f"{RANKED_PERCENT:g} % of the route."
)
CLEAR_1_M = 0.2  # E: the least turbid water above a pipe: clear ocean
BOAT_DEPTH_M = 2.0  # E: of the transceiver


class FollowRoute(InCurrent[TrackConfiguration]):
    """A `seamark.sim.engine.experiment.Experiment` that compares programs that follow a route."""

    task = "track"

    def plan(self, config: TrackConfiguration, *, seed: int, trial: int) -> TrialPlan:
        """Return the order of a trial's levels and all that was drawn for it."""
        drawn, own = self.drawn(config, seed=seed, trial=trial), config.for_trial(trial)
        courses = [
            self.course(config, seed=seed, trial=trial, level=level)
            for level in range(len(config.level_values()))
        ]
        told: dict[str, Any] = {
            "vehicle_name": own.vehicle,
            "route_kind": own.route,
            "routes": [course.route_m.tolist() for course in courses],
            "boats": [course.boat_m.tolist() for course in courses],
            "start_errors": [list(course.start_error_m) for course in courses],
        }
        stretches = self.stretches(config, seed=seed, trial=trial)
        pipes = [_told_of(course) for course in courses if course.pipe is not None]
        if pipes:
            water = self.water(own, seed=seed, trial=trial)
            told |= {"pipes": pipes, "pipe_attenuation_1_m": water.attenuation[0]}
        return TrialPlan(order=drawn.order, conditions=told | drawn.as_dict() | stretches)

    def target(self, config: TrackConfiguration, *, seed: int, trial: int) -> Target:
        """Return the weight on the bottom, below the start, or what of a pipe is there."""
        shape = config.for_trial(trial).target_shape()
        return Target(
            length_m=shape.length_m,
            width_m=shape.width_m,
            height_m=shape.height_m,
            seabed_m=SEABED_M,
            lettered=shape.lettered,
        )

    def water(self, config: TrackConfiguration, *, seed: int, trial: int) -> Water:
        """Return the water of a trial, which is more or less turbid above a pipe."""
        if config.route != PIPE:
            return super().water(config, seed=seed, trial=trial)
        least = min(CLEAR_1_M, config.pipe_turbidity_1_m)
        share = streams(seed, trial, 0).trial_water.random()
        return Water.grey(least + (config.pipe_turbidity_1_m - least) * share)

    def course(self, config: TrackConfiguration, *, seed: int, trial: int, level: int) -> Course:
        """Return the route of a level and the boat."""
        here, random = (
            self.at(config, seed=seed, trial=trial, level=level),
            streams(seed, trial, level),
        )
        _target, optics = target_and_optics(here)
        target = self.target(config, seed=seed, trial=trial)
        start = start_pose(optics, target, here.altitude_m)[:3]
        route = draw_route(here.route, here.route_length_m, start, random.route)
        shares = random.route.random(4).tolist()
        pipe, told = None, route
        if here.route == PIPE:
            pipe = lay_pipe(route, SEABED_M, PIPE_RADIUS_M, here.pipe_covered, random.route)
            told = _straight_on(route)
        return Course(
            route_m=route,
            told_m=told,
            pipe=pipe,
            boat_m=_boat(here, start, shares[:2]),
            start_error_m=polar(here.start_error_m * math.sqrt(shares[2]), shares[3]),
            most_start_error_m=here.start_error_m,
            noise=Noise(
                period_steps=round(here.fix_period_s / here.control_period_s),
                delay_s=here.fix_delay_s,
                range_sigma_m=here.fix_range_sigma_m,
                angle_sigma_rad=here.fix_angle_sigma_rad,
                dropout=here.fix_dropout,
            ),
            rng=random.usbl,
        )

    def metrics(self, config: TrackConfiguration, level: int, rows: Rows) -> dict[str, Any]:
        """Return the metrics of a level."""
        grid, speed = config.grid_point(level), config.level_values()[level]
        forward, reverse = load(config.vehicle).curve.limits.value
        facts = LevelFacts(
            level=level,
            speed=speed,
            dt=config.control_period_s,
            settle_s=0.0,
            limits_n=(forward, reverse),
            thrusters=len(load(config.vehicle).thrusters),
        )
        values = compute_all(METRICS, Following(rows, facts))
        held = float(values["followed"] or 0.0) >= HELD_QUALITY
        whole = {"level": level, "speed": speed, "held": held} | values
        return whole | ({"grid": grid} if grid else {})

    def trial_score(
        self, config: TrackConfiguration, levels: Sequence[Mapping[str, Any]]
    ) -> TrialScore:
        """Return the area under what was followed over the current [m/s]."""
        score = area_over_current(levels, "followed")
        weakest = sorted(levels, key=lambda level: float(level["speed"]))[:WEAK_LEVELS]
        got_on = mean([float(level["progress_percent"]) for level in weakest]) >= RANKED_PERCENT
        return TrialScore(
            score=score,
            level_held=held_up_to(levels),
            rankable=math.isfinite(score) and got_on,
            reason="" if got_on else NOT_FOLLOWED,
            overall=over_run(METRICS, levels),
        )


def _straight_on(route: Array) -> Array:
    """Return what is told of a pipe: its length in the direction in which it begins."""
    starts, shares = starts_of(route), np.arange(len(route)) / (len(route) - 1)
    told: Array = route[0] + starts[-1] * shares[:, None] * ((route[1] - route[0]) / starts[1])
    return told


def _told_of(course: Course) -> dict[str, Any]:
    """Return what a trial's conditions say of a pipe [m]; what is covered, by arc length."""
    pipe = course.pipe
    assert pipe is not None  # noqa: S101 - of a level with a pipe
    return {
        "axis": pipe.axis_m.tolist(),
        "seabed": pipe.seabed_m,
        "radius": pipe.radius_m,
        "covered": pipe.covered_m.tolist(),
    }


def _boat(config: TrackConfiguration, start: Array, shares: list[float]) -> Array:
    """Return where the acoustic transceiver is, (3,) NED."""
    off = config.boat_least_m + (config.boat_most_m - config.boat_least_m) * shares[0]
    north, east = polar(off, shares[1])
    return np.array([start[0] + north, start[1] + east, BOAT_DEPTH_M])


EXPERIMENT = FollowRoute()
