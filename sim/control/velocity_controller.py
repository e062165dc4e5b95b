"""From a velocity reference to thruster commands.

`model`: feedback by the DVL on top of the vehicle's own drag at the reference, with an observer of
the disturbance as the integral part; scaled by each axis's mass, so one tuning fits every vehicle.
`paper`: effort in proportion to the velocity error, as in the published experiment.

With either law heading and depth can be held: the yaw rate and heave references then move a set
point, and a PID brings the vehicle there.

The observer predicts the velocity from the thrust that is under way, so the thruster's lag and the
DVL's slow rate cost no phase; what the prediction misses is the disturbance (the current). It is an
integral that cannot wind up: it knows which thrust was cut. `sim/control/velocity_law.py` computes.
"""

from typing import NamedTuple, Protocol

import numpy as np

from seamark.sim.control import velocity_law as law
from seamark.sim.control.allocation import HEAVE, PITCH, ROLL, SURGE, SWAY, YAW, allocator
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import exp
from seamark.sim.physics.thrusters import packed
from seamark.sim.vehicles import Vehicle

# E: chosen so that both presets settle without overshoot with a thruster lag of 0.2 s.
DEPTH_HOLD = (0.8, 0.9, 0.05)  # [1/s, 1, 1/s] natural frequency, damping, integral rate
HEADING_HOLD = (2.0, 0.9, 0.3)
TILT_HOLD = (4.0, 0.9, 0.3)  # quick, and weak where the hull is small: as ArduSub's stabilise mode
VELOCITY_OBSERVER_1_S = 5.0  # how fast the estimated velocity follows the DVL, whatever is learnt
LARGEST_LEAD_M = 0.5  # [m] how far the depth's set point may run ahead of the vehicle
LARGEST_LEAD_RAD = 0.5


class Settings(Protocol):
    """What of a configuration the velocity controller reads."""

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


class Sensed(NamedTuple):
    """What the velocity controller knows at a tick."""

    velocity: tuple[float, float, float]  # [m/s] DVL, body frame
    depth: float  # [m]
    yaw: float  # [rad]
    yaw_rate: float  # [rad/s]
    fresh: bool  # whether the DVL has just measured, with success
    tilt: tuple[float, float] = (0.0, 0.0)  # roll, pitch [rad]
    tilt_rates: tuple[float, float] = (0.0, 0.0)  # p, q [rad/s]


class VelocityController:
    """Reference and measurements in, thruster commands out; one instance per level.

    `measured` is (1,) `velocity_law.MEASURED`: what is known at the present tick.
    """

    def __init__(self, vehicle: Vehicle, settings: Settings) -> None:
        self._axes, self._holds = _axes(vehicle, settings), _holds(vehicle)
        self._choice = _choice(vehicle, settings)
        directions = np.array([t.direction for t in vehicle.thrusters], dtype=np.float64)
        allocation = np.ascontiguousarray(allocator(vehicle), dtype=np.float64)
        efforts, curve = directions * _paper_gains(settings), packed(vehicle.curve)
        self._vehicle = (allocation, directions, efforts, curve)
        self._thrust, self._command = np.zeros((2, len(vehicle.thrusters)))
        self._out = (self._thrust, self._command)
        self.measured = np.zeros(1, law.MEASURED)
        self._values = self.measured.view(np.float64)  # the same memory: a record is slow to fill

    def reset(self) -> None:
        """Hold the measured depth and heading, and no tilt."""
        measured = self.measured[0]
        self._holds["target"] = (measured["depth"], measured["yaw"], 0.0, 0.0)
        self._holds["force"] = 0.0

    def sense(self, sensed: Sensed) -> None:
        """Take measurements over; who writes to `measured` by itself need not."""
        velocity, depth, yaw, yaw_rate, fresh, tilt, tilt_rates = sensed
        self._values[:] = (*velocity, depth, yaw, yaw_rate, fresh, *tilt, *tilt_rates)

    def step(self, reference: tuple[float, float, float, float], dt: float) -> Array:
        """Return the commands, (n,) in [-1, 1]; the array is reused at the next call."""
        surge, sway, heave, turn = reference
        law.step(
            (float(surge), float(sway), float(heave), float(turn)),
            *(self.measured, dt, self._choice, self._axes, self._holds),
            *(self._vehicle, self._out),
        )
        return self._command


def _axes(vehicle: Vehicle, settings: Settings) -> law.Records:
    """Return what is known of surge, sway and heave, (3,) records `velocity_law.AXIS`."""
    axes = np.zeros(3, law.AXIS)
    inertia = vehicle.mass_rigid() + vehicle.mass_added()
    slow = exp(-settings.velocity_observer_1_s / settings.dvl_rate_hz)
    quick = exp(-VELOCITY_OBSERVER_1_S / settings.dvl_rate_hz)
    for axis in (SURGE, SWAY, HEAVE):
        mass = float(inertia[axis, axis])
        axes[axis]["mass"] = mass
        axes[axis]["gain"] = mass * settings.velocity_bandwidth_1_s
        axes[axis]["correct_force"] = mass * (1.0 - slow) * (1.0 - quick) * settings.dvl_rate_hz
    axes["linear"] = vehicle.linear_drag()[:3]
    axes["quadratic"] = vehicle.quadratic_drag()[:3]
    axes["lag"] = vehicle.lag.scalar
    axes["correct_velocity"] = 1.0 - slow * quick
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


def _choice(vehicle: Vehicle, settings: Settings) -> law.Records:
    """Return the settings and limits, (1,) record `velocity_law.CHOICE`."""
    forward, reverse = vehicle.curve.limits.value
    choice = (
        *(settings.velocity_law == "paper", settings.depth_hold, settings.heading_hold),
        *(settings.tilt_hold, settings.reference_limit_m_s, forward, reverse),
    )
    return np.array([choice], law.CHOICE)


def _paper_gains(settings: Settings) -> Array:
    """Return the effort per m/s of error on surge, sway and heave, (3,)."""
    surge, sway = settings.paper_gain_surge, settings.paper_gain_sway
    return np.array([surge, sway, 0.0 if settings.depth_hold else surge])
