"""From a velocity reference to thruster commands.

`model`: feedback by the DVL on top of the vehicle's own drag at the reference, with an observer of
the disturbance as the integral part; scaled by each axis's mass, so one tuning fits every vehicle.
`paper`: effort in proportion to the velocity error, as in the published experiment.

With either law heading and depth can be held: the yaw rate and heave references then move a set
point, and a PID brings the vehicle there.
"""

import math
from typing import NamedTuple, Protocol

import numpy as np
from numba import njit

from sim.allocation import HEAVE, PITCH, ROLL, SURGE, SWAY, YAW, allocator
from sim.elementary import exp
from sim.thrusters import commands_for, packed
from sim.vehicles import Array, Vehicle

# E: chosen so that both presets settle without overshoot with a thruster lag of 0.2 s.
DEPTH_HOLD = (0.8, 0.9, 0.05)  # [1/s, 1, 1/s] natural frequency, damping, integral rate
HEADING_HOLD = (2.0, 0.9, 0.3)
TILT_HOLD = (4.0, 0.9, 0.3)  # quick, and weak where the hull is small: as ArduSub's stabilise mode
VELOCITY_OBSERVER_1_S = 5.0  # how fast the estimated velocity follows the DVL, whatever is learnt
LARGEST_LEAD_M = 0.5  # [m] how far the depth's set point may run ahead of the vehicle
LARGEST_LEAD_RAD = 0.5
SHALLOWEST_M = 0.5  # [m] the water has no surface in the equations; the depth hold stays below it
FASTEST_YAW_RAD_S = 0.6  # [rad/s] S: COLA2's open-loop limit of the Girona 500


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


class _Hold:
    """PID on a set point that the references move; returns a force or a moment."""

    def __init__(self, inertia: float, tuning: tuple[float, float, float], lead: float) -> None:
        frequency, damping, rate = tuning
        self.stiffness = inertia * frequency * frequency
        self.friction = inertia * 2.0 * damping * frequency
        self.rate = self.stiffness * rate
        self.lead = lead
        self.target = 0.0
        self.force = 0.0  # the integral's part

    def reset(self, place: float) -> None:
        self.target, self.force = place, 0.0

    def step(self, error: float, speed_error: float, dt: float) -> float:
        """Return the push for an error of the place and of the speed."""
        self.force += self.rate * error * dt
        return self.stiffness * error + self.friction * speed_error + self.force


class _Axis:
    """Velocity of one axis: drag at the reference, feedback, and a disturbance that is learnt.

    The observer predicts the velocity from the thrust that is under way, so the thruster's lag and
    the DVL's slow rate cost no phase; what the prediction misses is the disturbance (the current).
    It is an integral that cannot wind up: it knows which thrust was cut.
    """

    def __init__(self, axis: int, vehicle: Vehicle, settings: Settings) -> None:
        self.linear = float(vehicle.linear_drag()[axis])
        self.quadratic = float(vehicle.quadratic_drag()[axis])
        self.mass = float((vehicle.mass_rigid() + vehicle.mass_added())[axis, axis])
        self.lag = vehicle.lag.scalar
        self.gain = self.mass * settings.velocity_bandwidth_1_s
        slow = exp(-settings.velocity_observer_1_s / settings.dvl_rate_hz)
        quick = exp(-VELOCITY_OBSERVER_1_S / settings.dvl_rate_hz)
        self.correct_velocity = 1.0 - slow * quick
        self.correct_force = self.mass * (1.0 - slow) * (1.0 - quick) * settings.dvl_rate_hz
        self.velocity = 0.0  # [m/s] estimated
        self.disturbance = 0.0  # [N] estimated
        self.thrust = 0.0  # [N] estimated

    def force(self, wanted: float, measured: float, *, fresh: bool) -> float:
        """Return the force [N] to ask for; `fresh` says that the measurement is new and good."""
        if fresh:
            missed = measured - self.velocity
            self.velocity += self.correct_velocity * missed
            self.disturbance += self.correct_force * missed
        return self.drag(wanted) + self.gain * (wanted - self.velocity) - self.disturbance

    def predict(self, force: float, dt: float) -> None:
        """Move the estimate on; `force` [N] is what the thrusters were really told to give."""
        self.thrust += (force - self.thrust) * (dt / (self.lag + dt))
        push = self.thrust + self.disturbance - self.drag(self.velocity)
        self.velocity += push * (dt / self.mass)

    def drag(self, velocity: float) -> float:
        """Return the vehicle's drag [N] at a velocity through the water."""
        return (self.linear + self.quadratic * abs(velocity)) * velocity


@njit(cache=True, error_model="numpy")
def _share_out(
    allocator: Array,
    wrench: tuple[float, float, float, float],
    curve: Array,
    thrust: Array,
    command: Array,
) -> None:
    """Write each thruster's thrust [N] and command for surge, sway, heave [N] and yaw [N m]."""
    surge, sway, heave, yaw = wrench
    for i in range(thrust.size):
        row = allocator[i]
        thrust[i] = row[SURGE] * surge + row[SWAY] * sway + row[HEAVE] * heave + row[YAW] * yaw
    commands_for(thrust, curve, command)


@njit(cache=True, error_model="numpy")
def _add_share(allocator: Array, axis: int, effort: float, thrust: Array) -> None:
    """Add each thruster's part [N] of a force or moment about one axis."""
    for i in range(thrust.size):
        thrust[i] += allocator[i, axis] * effort


class VelocityController:
    """Reference and measurements in, thruster commands out; one instance per level."""

    def __init__(self, vehicle: Vehicle, settings: Settings) -> None:
        self._settings = settings
        self._curve = packed(vehicle.curve)
        self._forward, self._reverse = vehicle.curve.limits.value
        self._allocator = np.ascontiguousarray(allocator(vehicle), dtype=np.float64)
        self._axes = [_Axis(axis, vehicle, settings) for axis in (SURGE, SWAY, HEAVE)]
        inertia = vehicle.mass_rigid() + vehicle.mass_added()
        self._depth = _Hold(float(inertia[HEAVE, HEAVE]), DEPTH_HOLD, LARGEST_LEAD_M)
        self._heading = _Hold(float(inertia[YAW, YAW]), HEADING_HOLD, LARGEST_LEAD_RAD)
        self._tilt = [
            (axis, _Hold(float(inertia[axis, axis]), TILT_HOLD, LARGEST_LEAD_RAD))
            for axis in (ROLL, PITCH)
        ]
        self._directions = [tuple(map(float, t.direction)) for t in vehicle.thrusters]
        self._pushes = [
            (i, axis, share)
            for i, direction in enumerate(self._directions)
            for axis, share in enumerate(direction)
            if share != 0.0
        ]
        self._efforts = self._paper_efforts()
        self._thrust = np.zeros(len(vehicle.thrusters))
        self._command = np.zeros(len(vehicle.thrusters))

    def reset(self, sensed: Sensed) -> None:
        """Hold the depth and heading of now."""
        self._depth.reset(sensed.depth)
        self._heading.reset(sensed.yaw)
        for _axis, hold in self._tilt:
            hold.reset(0.0)

    def step(
        self, reference: tuple[float, float, float, float], sensed: Sensed, dt: float
    ) -> Array:
        """Return the commands, (n,) in [-1, 1]; the array is reused at the next call."""
        limit = self._settings.reference_limit_m_s
        surge, sway, heave = (min(max(value, -limit), limit) for value in reference[:3])
        yaw_rate = min(max(reference[3], -FASTEST_YAW_RAD_S), FASTEST_YAW_RAD_S)
        wanted = (surge, sway, heave)
        moment = self._yaw_moment(yaw_rate, sensed, dt)
        if self._settings.velocity_law == "paper":
            down = self._hold_depth(heave, sensed, dt) if self._settings.depth_hold else 0.0
            self._allocate((0.0, 0.0, down, moment))
            self._add_paper_efforts(wanted, sensed.velocity)
        else:
            self._allocate((*self._forces(wanted, sensed, dt), moment))
            self._predict(dt)
            if self._settings.tilt_hold:
                self._level_out(sensed, dt)
        return self._command

    def _forces(
        self, wanted: tuple[float, float, float], sensed: Sensed, dt: float
    ) -> tuple[float, float, float]:
        surge, sway, heave = (
            axis.force(want, have, fresh=sensed.fresh)
            for axis, want, have in zip(self._axes, wanted, sensed.velocity, strict=True)
        )
        if self._settings.depth_hold:
            heave = self._hold_depth(wanted[HEAVE], sensed, dt)
        return surge, sway, heave

    def _predict(self, dt: float) -> None:
        """Tell the observers what the thrusters can really give."""
        forces = [0.0, 0.0, 0.0]
        thrusts = self._thrust.tolist()
        for i, axis, share in self._pushes:
            forces[axis] += share * min(max(thrusts[i], -self._reverse), self._forward)
        for observed, force in zip(self._axes, forces, strict=True):
            observed.predict(force, dt)

    def _hold_depth(self, heave: float, sensed: Sensed, dt: float) -> float:
        hold = self._depth
        target = _near(hold.target + heave * dt, sensed.depth, hold.lead)
        hold.target = max(target, SHALLOWEST_M)
        return hold.step(hold.target - sensed.depth, heave - sensed.velocity[HEAVE], dt)

    def _yaw_moment(self, rate: float, sensed: Sensed, dt: float) -> float:
        if not self._settings.heading_hold:
            return 0.0 if rate == 0.0 else self._heading.friction * (rate - sensed.yaw_rate)
        hold = self._heading
        error = _wrapped(hold.target + rate * dt - sensed.yaw)
        error = min(max(error, -hold.lead), hold.lead)
        hold.target = sensed.yaw + error
        return hold.step(error, rate - sensed.yaw_rate, dt)

    def _allocate(self, wrench: tuple[float, float, float, float]) -> None:
        _share_out(self._allocator, wrench, self._curve, self._thrust, self._command)

    def _level_out(self, sensed: Sensed, dt: float) -> None:
        """Add what brings roll and pitch to zero; a moment, so the forces stay what they are."""
        for (axis, hold), angle, rate in zip(
            self._tilt, sensed.tilt, sensed.tilt_rates, strict=True
        ):
            moment = hold.step(min(max(-angle, -hold.lead), hold.lead), -rate, dt)
            _add_share(self._allocator, axis, moment, self._thrust)
        commands_for(self._thrust, self._curve, self._command)

    def _paper_efforts(self) -> list[list[float]]:
        """Return each thruster's effort per m/s of error on surge, sway and heave."""
        gains = {
            SURGE: self._settings.paper_gain_surge,
            SWAY: self._settings.paper_gain_sway,
            HEAVE: 0.0 if self._settings.depth_hold else self._settings.paper_gain_surge,
        }
        return [[gains[axis] * direction[axis] for axis in gains] for direction in self._directions]

    def _add_paper_efforts(
        self, wanted: tuple[float, float, float], measured: tuple[float, float, float]
    ) -> None:
        errors = [want - have for want, have in zip(wanted, measured, strict=True)]
        for i, gains in enumerate(self._efforts):
            effort = gains[0] * errors[0] + gains[1] * errors[1] + gains[2] * errors[2]
            self._command[i] = min(max(float(self._command[i]) + effort, -1.0), 1.0)


def _near(target: float, place: float, lead: float) -> float:
    return min(max(target, place - lead), place + lead)


def _wrapped(angle: float) -> float:
    """Return the angle within [-pi, pi)."""
    if -math.pi <= angle < math.pi:
        return angle
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))
