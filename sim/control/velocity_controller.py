"""Velocity control: from a velocity reference to thruster commands.

`model`: feedback of the DVL and feed-forward of the drag at the reference, with a disturbance
observer as the integral part; scaled by the mass of each axis, so one tuning fits every vehicle.
`paper`: effort proportional to the velocity error, as in the published experiment.

With either law heading and depth can be held: the yaw rate and heave references then move a set
point, which a PID controller tracks.

The observer predicts the velocity from the applied thrust, so the thruster lag and the low rate of
the DVL cost no phase; the prediction error is due to the disturbance (the current). It is an
integral without windup, since it knows the saturated thrust. The arithmetic is in velocity_law.py.
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from seamark.sim.control import velocity_law as law
from seamark.sim.control.allocation import HEAVE, PITCH, ROLL, SURGE, SWAY, YAW, allocator
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.numerics.libm import exp
from seamark.sim.physics.thrusters import pack_curve
from seamark.sim.vehicles import Vehicle

# E: chosen so that both presets settle without overshoot with a thruster lag of 0.2 s.
DEPTH_HOLD = (0.8, 0.9, 0.05)  # [1/s, 1, 1/s] natural frequency, damping, integral rate
HEADING_HOLD = (2.0, 0.9, 0.3)
TILT_HOLD = (4.0, 0.9, 0.3)  # fast, and weak for a small hull: like the stabilize mode of ArduSub
VELOCITY_OBSERVER_1_S = 5.0  # bandwidth of the velocity estimate
LARGEST_LEAD_M = 0.5  # [m] largest distance of the depth set point from the vehicle
LARGEST_LEAD_RAD = 0.5


class Settings(Protocol):
    """The part of a configuration that the velocity controller reads."""

    velocity_law: str
    reference_limit_m_s: float
    velocity_bandwidth_1_s: float
    velocity_observer_1_s: float
    dvl_rate_hz: float
    paper_gain_surge: float
    paper_gain_sway: float
    heading_hold: bool
    depth_hold: bool
    tilt_hold: bool


class VelocityController:
    """From reference and measurements to thruster commands; one instance per level.

    `measured` is (1,) `velocity_law.MEASURED`: the measurements of the present step.
    """

    def __init__(self, vehicle: Vehicle, settings: Settings) -> None:
        self._axes, self._holds = _axes(vehicle, settings), _holds(vehicle)
        self._settings_record = _settings_record(vehicle, settings)
        directions = np.array([t.direction for t in vehicle.thrusters], dtype=np.float64)
        allocation = np.ascontiguousarray(allocator(vehicle), dtype=np.float64)
        efforts, curve = directions * _paper_gains(settings), pack_curve(vehicle.curve)
        self.thrusters = law.Thrusters(allocation, directions, efforts, curve)
        self._out = law.Outputs(*np.zeros((2, len(vehicle.thrusters))))
        self.measured = np.zeros(1, law.MEASURED)
        self._law = SameTypes(law.step)

    def records(self) -> tuple[law.Records, law.Records, law.Records]:
        """Return settings (1,), axes (3,) and holds (4,), for compiled code."""
        return self._settings_record, self._axes, self._holds

    def reset(self) -> None:
        """Hold the measured depth and heading, and zero tilt."""
        measured = self.measured[0]
        self._holds["target"] = (measured["depth"], measured["yaw"], 0.0, 0.0)
        self._holds["force"] = 0.0

    def step(self, reference: Sequence[float], dt: float) -> Array:
        """Return the commands, (n,) in [-1, 1]; the array is reused at the next call."""
        surge, sway, heave, yaw_rate = reference
        self._law.call(
            law.Reference(float(surge), float(sway), float(heave), float(yaw_rate)),
            self.measured,
            dt,
            self._settings_record,
            self._axes,
            self._holds,
            self.thrusters,
            self._out,
        )
        return self._out.command


def _axes(vehicle: Vehicle, settings: Settings) -> law.Records:
    """Return the states of surge, sway and heave, (3,) records `velocity_law.AXIS`."""
    axes = np.zeros(3, law.AXIS)
    inertia = vehicle.mass_rigid() + vehicle.mass_added()
    slow = exp(-settings.velocity_observer_1_s / settings.dvl_rate_hz)
    fast = exp(-VELOCITY_OBSERVER_1_S / settings.dvl_rate_hz)
    for axis in (SURGE, SWAY, HEAVE):
        mass = float(inertia[axis, axis])
        axes[axis]["mass"] = mass
        axes[axis]["gain"] = mass * settings.velocity_bandwidth_1_s
        axes[axis]["correct_force"] = mass * (1.0 - slow) * (1.0 - fast) * settings.dvl_rate_hz
    axes["linear"] = vehicle.linear_drag()[:3]
    axes["quadratic"] = vehicle.quadratic_drag()[:3]
    axes["lag"] = vehicle.lag.scalar
    axes["correct_velocity"] = 1.0 - slow * fast
    return axes


def _holds(vehicle: Vehicle) -> law.Records:
    """Return the PIDs of depth, heading, roll and pitch, (4,) records `velocity_law.HOLD`."""
    holds = np.zeros(4, law.HOLD)
    inertia = vehicle.mass_rigid() + vehicle.mass_added()
    for at, axis, (frequency, damping, rate), lead in (
        (law.DEPTH, HEAVE, DEPTH_HOLD, LARGEST_LEAD_M),
        (law.HEADING, YAW, HEADING_HOLD, LARGEST_LEAD_RAD),
        (law.ROLLING, ROLL, TILT_HOLD, LARGEST_LEAD_RAD),
        (law.PITCHING, PITCH, TILT_HOLD, LARGEST_LEAD_RAD),
    ):
        own = float(inertia[axis, axis])
        stiffness = own * frequency * frequency
        friction = own * 2.0 * damping * frequency
        holds[at] = (stiffness, friction, stiffness * rate, lead, 0.0, 0.0)
    return holds


def _settings_record(vehicle: Vehicle, settings: Settings) -> law.Records:
    """Return the settings and limits, (1,) record `velocity_law.CHOICE`."""
    forward, reverse = vehicle.curve.limits.value
    setting = (
        *(settings.velocity_law == "paper", settings.depth_hold, settings.heading_hold),
        *(settings.tilt_hold, settings.reference_limit_m_s, forward, reverse),
    )
    return np.array([setting], law.SETTINGS)


def _paper_gains(settings: Settings) -> Array:
    """Return the effort per m/s of error on surge, sway and heave, (3,)."""
    surge, sway = settings.paper_gain_surge, settings.paper_gain_sway
    return np.array([surge, sway, 0.0 if settings.depth_hold else surge])
