"""The conditions of a trial: what is drawn once for all of its levels, and how.

Each group has a random stream of its own that depends on seed and trial. The numbers drawn do not
depend on the settings, which only scale them: switching one spread off changes nothing else, and
two runs with other spreads share the rest of their luck.
"""

from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from seamark.sim.numerics.random_streams import Streams
from seamark.sim.physics.current import Change, Pattern
from seamark.sim.settings.trial_spreads import TrialSpreadSettings
from seamark.sim.vehicles.variation import VehicleFactors

Vector3 = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class CurrentDraw:
    """What is drawn of the current; multiplied with or added to the settings of its pattern."""

    azimuth_rad: float = 0.0  # added
    swing_factor: float = 1.0  # of the amplitude of the direction
    swing_period_factor: float = 1.0
    swing_phase_rad: float = 0.0
    wave_period_factor: float = 1.0  # of the speed's sinusoid
    wave_phase_rad: float = 0.0
    gust_factor: float = 1.0
    gust_time_factor: float = 1.0
    changes: tuple[Change, ...] = ()

    def of(self, pattern: Pattern) -> Pattern:
        """Return the pattern with what was drawn."""
        return replace(
            pattern,
            azimuth_rad=pattern.azimuth_rad + self.azimuth_rad,
            azimuth_swing_rad=pattern.azimuth_swing_rad * self.swing_factor,
            azimuth_period_s=pattern.azimuth_period_s * self.swing_period_factor,
            azimuth_phase_rad=self.swing_phase_rad,
            speed_period_s=pattern.speed_period_s * self.wave_period_factor,
            speed_phase_rad=self.wave_phase_rad,
            gust_share=pattern.gust_share * self.gust_factor,
            gust_time_s=pattern.gust_time_s * self.gust_time_factor,
            changes=self.changes,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialConditions:
    """All that a trial draws; the defaults are nominal: nothing differs from the settings."""

    current: CurrentDraw = field(default_factory=CurrentDraw)
    start_offset_m: tuple[float, float] = (0.0, 0.0)  # of the start from the station: north, east
    start_heading_rad: float = 0.0
    dvl_bias_m_s: Vector3 = (0.0, 0.0, 0.0)  # surge, sway, heave
    ahrs_bias_rad: Vector3 = (0.0, 0.0, 0.0)  # roll, pitch, yaw
    camera_delay_steps: int = 0  # control steps
    command_delay_steps: int = 0
    vehicle: VehicleFactors = field(default_factory=VehicleFactors)
    thruster_gains: tuple[float, ...] | None = None  # real thrust over nominal; None: all 1
    order: tuple[int, ...] = ()  # level after level in time; (): as listed

    def as_dict(self) -> dict[str, Any]:
        """Return them as plain JSON values."""
        return asdict(self)


NOMINAL = TrialConditions()


def draw_conditions(
    spread: TrialSpreadSettings, random: Streams, *, thrusters: int, levels: int
) -> TrialConditions:
    """Return the conditions of a trial; `random` must be fresh."""
    dvl_bias, ahrs_bias = _sensor_bias(spread, random.trial_sensors)
    north, east, heading = random.trial_start.uniform(-1.0, 1.0, 3).tolist()
    camera, command = random.trial_delays.random(2).tolist()
    factors, gains = _vehicle(spread, random.trial_vehicle, thrusters)
    order = random.trial_order.permutation(levels).tolist()
    return TrialConditions(
        current=_current(spread, random.trial_current),
        start_offset_m=(spread.start_offset_m * north, spread.start_offset_m * east),
        start_heading_rad=spread.start_heading_rad * heading,
        dvl_bias_m_s=dvl_bias,
        ahrs_bias_rad=ahrs_bias,
        camera_delay_steps=int(camera * (spread.camera_delay_steps + 1)),
        command_delay_steps=int(command * (spread.command_delay_steps + 1)),
        vehicle=factors,
        thruster_gains=gains,
        order=tuple(order) if spread.shuffle_levels else tuple(range(levels)),
    )


def _current(spread: TrialSpreadSettings, random: np.random.Generator) -> CurrentDraw:
    azimuth, swing_phase, wave_phase = random.uniform(-1.0, 1.0, 3).tolist()
    swing, swing_period, wave_period = random.uniform(-1.0, 1.0, 3).tolist()
    gust, gust_time = random.uniform(-1.0, 1.0, 2).tolist()
    return CurrentDraw(
        azimuth_rad=spread.azimuth_spread_rad * azimuth,
        swing_factor=1.0 + spread.swing_spread * swing,
        swing_period_factor=1.0 + spread.swing_spread * swing_period,
        swing_phase_rad=spread.phase_spread_rad * swing_phase,
        wave_period_factor=1.0 + spread.swing_spread * wave_period,
        wave_phase_rad=spread.phase_spread_rad * wave_phase,
        gust_factor=1.0 + spread.gust_spread * gust,
        gust_time_factor=1.0 + spread.gust_spread * gust_time,
        changes=_changes(spread, random),
    )


def _changes(spread: TrialSpreadSettings, random: np.random.Generator) -> tuple[Change, ...]:
    """Return one change of the current or, in half of the trials, two."""
    times, (second,) = random.random(2).tolist(), random.random(1).tolist()
    turns, shares = random.uniform(-1.0, 1.0, (2, 2)).tolist()
    windows = ((0.2, 0.5), (0.6, 0.85))  # shares of a level: time to settle before and after
    changes = tuple(
        Change(
            at_s=spread.level_duration_s * (first + (last - first) * time),
            turn_rad=spread.change_turn_rad * turn,
            speed_share=spread.change_speed_share * share,
        )
        for (first, last), time, turn, share in zip(windows, times, turns, shares, strict=True)
    )
    return changes if second < 0.5 else changes[:1]


def _sensor_bias(
    spread: TrialSpreadSettings, random: np.random.Generator
) -> tuple[Vector3, Vector3]:
    """Return the bias of DVL [m/s] and AHRS [rad]; that of a DVL's axis is never small."""
    sizes, signs = random.uniform(0.5, 1.0, 3).tolist(), random.random(3).tolist()
    dvl = [
        spread.dvl_bias_spread_m_s * (size if sign < 0.5 else -size)
        for size, sign in zip(sizes, signs, strict=True)
    ]
    roll, pitch, yaw = random.uniform(-1.0, 1.0, 3).tolist()
    tilt, heading = spread.ahrs_tilt_bias_rad, spread.ahrs_yaw_bias_rad
    return (dvl[0], dvl[1], dvl[2]), (tilt * roll, tilt * pitch, heading * yaw)


def _vehicle(
    spread: TrialSpreadSettings, random: np.random.Generator, thrusters: int
) -> tuple[VehicleFactors, tuple[float, ...]]:
    """Return the factors of the vehicle's parameters and of its thrusters' gains."""
    mass, *axes = random.uniform(-1.0, 1.0, 13).tolist()
    weak, which, loss = random.random(3).tolist()
    gains = [1.0 + spread.thrust_spread * one for one in random.uniform(-1.0, 1.0, thrusters)]
    if weak < spread.weak_thruster_probability:
        gains[int(which * thrusters)] *= 1.0 - spread.weak_thruster_loss * (0.5 + 0.5 * loss)
    factors = VehicleFactors(
        mass=1.0 + spread.mass_spread * mass,
        added_mass=tuple(1.0 + spread.added_mass_spread * one for one in axes[:6]),
        drag=tuple(1.0 + spread.drag_spread * one for one in axes[6:]),
    )
    return factors, tuple(float(gain) for gain in gains)
