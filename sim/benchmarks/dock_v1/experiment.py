"""Entering a dock: how a level starts, and what it scores."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from seamark.sim.benchmarks.dock_v1 import scene
from seamark.sim.benchmarks.dock_v1.settings import RAILS_M, DockConfiguration, keel_m
from seamark.sim.benchmarks.in_current import InCurrent
from seamark.sim.benchmarks.level_area import area_over_current, held_up_to
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water
from seamark.sim.engine.dock_in_loop import Dock, Light
from seamark.sim.engine.experiment import TrialPlan, TrialScore
from seamark.sim.engine.world import Conditions, target_and_optics
from seamark.sim.metrics.docking import METRICS, STRIKE_M_S, Docking
from seamark.sim.metrics.metric import compute_all, over_run
from seamark.sim.numerics.libm import PI, polar
from seamark.sim.numerics.random_streams import Streams, streams
from seamark.sim.recording.telemetry import Rows
from seamark.sim.sensors.usbl import Noise
from seamark.sim.vehicles import load

WEAK_LEVELS = 2  # number of weakest currents, in one of which a program must dock to rank
NOT_DOCKED = f"The vehicle did not dock in any of the {WEAK_LEVELS} weakest currents of a trial."
GREEN = 1


class Start(NamedTuple):
    """Where a level starts: north and east of the dock, above the least height, and heading."""

    offset_m: tuple[float, float]
    above_m: float
    heading_rad: float


class EnterDock(InCurrent[DockConfiguration]):
    """A `seamark.sim.engine.experiment.Experiment` that compares programs that enter a dock."""

    task = "dock"

    def plan(self, config: DockConfiguration, *, seed: int, trial: int) -> TrialPlan:
        """Return the order of a trial's levels and all that was drawn for it."""
        drawn, own = self.drawn(config, seed=seed, trial=trial), config.for_trial(trial)
        levels = range(len(config.level_values()))
        starts = [self.start(config, seed=seed, trial=trial, level=level) for level in levels]
        told = {
            "vehicle_name": own.vehicle,
            "dock_heading_rad": self.heading(config, seed=seed, trial=trial),
            "turbidity_1_m": self.turbidity(own, seed=seed, trial=trial),
            "starts": [start._asdict() for start in starts],
        }
        stretches = self.stretches(config, seed=seed, trial=trial)
        return TrialPlan(order=drawn.order, conditions=told | drawn.as_dict() | stretches)

    def heading(self, config: DockConfiguration, *, seed: int, trial: int) -> float:
        """Return the heading of the dock [rad], about that from which the current comes."""
        drawn = self.drawn(config, seed=seed, trial=trial)
        share = 2.0 * float(streams(seed, trial, 0).trial_work.random()) - 1.0
        mean = config.current_azimuth_rad + drawn.current.azimuth_rad
        turned = mean + config.into_current_rad * share
        return turned - 2.0 * PI * math.floor((turned + PI) / (2.0 * PI))

    def turbidity(self, config: DockConfiguration, *, seed: int, trial: int) -> float:
        """Return the attenuation that suspended matter adds [1/m]."""
        return config.turbidity_1_m * float(streams(seed, trial, 0).trial_water.random())

    def start(self, config: DockConfiguration, *, seed: int, trial: int, level: int) -> Start:
        """Return where a level starts."""
        away, bearing, rise, heading = streams(seed, trial, level).things.random(4).tolist()
        least, most = config.approach_least_m, config.approach_most_m
        return Start(
            offset_m=polar(least + (most - least) * away, bearing),
            above_m=config.approach_rise_m * rise,
            heading_rad=PI * (2.0 * heading - 1.0),
        )

    def water(self, config: DockConfiguration, *, seed: int, trial: int) -> Water:
        """Return the water of the settings with the suspended matter of the trial."""
        clear = super().water(config, seed=seed, trial=trial)
        more = self.turbidity(config, seed=seed, trial=trial)
        red, green, blue = (one + more for one in clear.attenuation)
        return replace(clear, attenuation=(red, green, blue))

    def target(self, config: DockConfiguration, *, seed: int, trial: int) -> Target:
        """Return the marker of the dock."""
        return scene.target(self.heading(config, seed=seed, trial=trial))

    def dock(self, config: DockConfiguration, *, seed: int, trial: int, level: int) -> Dock:
        """Return the dock of the trial's vehicle."""
        here = self.at(config, seed=seed, trial=trial, level=level)
        vehicle, random = load(here.vehicle), streams(seed, trial, level)
        heading = self.heading(config, seed=seed, trial=trial)
        target, (_nominal, optics) = scene.target(heading), target_and_optics(here)
        rails = scene.SEABED_M - RAILS_M
        return Dock(
            things=(scene.cage(scene.keel_of(vehicle), heading),),
            top_m=rails - scene.MOUTH_M - scene.TUBE_M,
            mouth_m=rails - scene.MOUTH_M,
            seat_m=scene.seat(vehicle),
            heading_rad=heading,
            keel_m=keel_m(vehicle),
            noise=Noise(
                period_steps=round(here.fix_period_s / here.control_period_s),
                delay_s=here.fix_delay_s,
                range_sigma_m=here.fix_range_sigma_m,
                angle_sigma_rad=here.fix_angle_sigma_rad,
                dropout=here.fix_dropout,
            ),
            least_range_m=here.fix_least_m,
            light=Light(
                sigma_px=here.light_sigma_px,
                most_depths=here.light_depths,
                attenuation_1_m=self.water(here, seed=seed, trial=trial).attenuation[GREEN],
                centre_px=optics.principal_px,
                at_m=target.top_centre(),
            ),
            fixes=random.usbl,
            pixels=random.search,
        )

    def _conditions(
        self, config: DockConfiguration, *, seed: int, trial: int, level: int
    ) -> tuple[Conditions, Streams]:
        conditions, random = super()._conditions(config, seed=seed, trial=trial, level=level)
        start = self.start(config, seed=seed, trial=trial, level=level)
        own = replace(
            conditions.trial,
            start_offset_m=start.offset_m,
            # The station has the heading of the marker's letters.
            start_heading_rad=start.heading_rad,
        )
        return replace(conditions, trial=own, start_above_m=start.above_m), random

    def metrics(self, config: DockConfiguration, level: int, rows: Rows) -> dict[str, Any]:
        """Return the metrics of a level."""
        grid, speed = config.grid_point(level), config.level_values()[level]
        docking = Docking(rows, config.control_period_s, strike_n(config))
        values = compute_all(METRICS, docking)
        held = docking.docked and docking.strikes == 0
        whole = {"level": level, "speed": speed, "held": held} | values
        return whole | ({"grid": grid} if grid else {})

    def trial_score(
        self, config: DockConfiguration, levels: Sequence[Mapping[str, Any]]
    ) -> TrialScore:
        """Return the area under the quality of docking over the current [m/s]."""
        score = area_over_current(levels, "docking")
        weakest = sorted(levels, key=lambda level: float(level["speed"]))[:WEAK_LEVELS]
        docked = any(float(level["docked"]) > 0.0 for level in weakest)
        return TrialScore(
            score=score,
            level_held=held_up_to(levels),
            rankable=math.isfinite(score) and docked,
            reason="" if docked else NOT_DOCKED,
            overall=over_run(METRICS, levels),
        )


def strike_n(config: DockConfiguration) -> float:
    """Return the force [N] that stops the vehicle from `STRIKE_M_S` within a control step."""
    vehicle = load(config.vehicle)
    mass = float(vehicle.mass_rigid()[0, 0] + vehicle.mass_added()[0, 0])
    return mass * STRIKE_M_S / config.control_period_s


EXPERIMENT = EnterDock()
