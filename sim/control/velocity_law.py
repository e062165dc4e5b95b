"""The velocity controller's arithmetic, compiled: it runs at every control tick.

What it knows stands in records of NumPy: the three axes of translation, the four holds, a setting.
All functions change their records in place.
"""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.control.allocation import HEAVE, PITCH, ROLL, SURGE, SWAY, YAW
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.thrusters import commands_for

Records = NDArray[np.void]
Record = Any  # one of them; Numba reads its fields as attributes

DEPTH, HEADING, ROLLING, PITCHING = range(4)  # places of the holds
SHALLOWEST_M = 0.5  # [m] the water has no surface in the equations; the depth hold stays below it
FASTEST_YAW_RAD_S = 0.6  # [rad/s] S: COLA2's open-loop limit of the Girona 500

AXIS = np.dtype(
    [
        ("linear", "f8"),  # [N s/m] the vehicle's drag
        ("quadratic", "f8"),  # [N s²/m²]
        ("mass", "f8"),  # [kg] with added mass
        ("lag", "f8"),  # [s] the thrusters'
        ("gain", "f8"),  # [N s/m]
        ("correct_velocity", "f8"),  # [1] share of what the prediction missed
        ("correct_force", "f8"),  # [N s/m]
        ("velocity", "f8"),  # [m/s] estimated
        ("disturbance", "f8"),  # [N] estimated
        ("thrust", "f8"),  # [N] estimated
    ]
)
HOLD = np.dtype(
    [
        ("stiffness", "f8"),  # [N/m, N m/rad]
        ("friction", "f8"),  # [N s/m, N m s/rad]
        ("rate", "f8"),  # [N/(m s), N m/(rad s)] the integral's
        ("lead", "f8"),  # [m, rad] how far the set point may run ahead of the vehicle
        ("target", "f8"),  # [m, rad]
        ("force", "f8"),  # [N, N m] the integral's part
    ]
)
CHOICE = np.dtype(
    [
        ("paper", "?"),  # effort in proportion to the velocity error, as published
        ("hold_depth", "?"),
        ("hold_heading", "?"),
        ("hold_tilt", "?"),
        ("limit", "f8"),  # [m/s] of a velocity reference
        ("forward", "f8"),  # [N] the most that a thruster gives
        ("reverse", "f8"),  # [N]
    ]
)
MEASURED = np.dtype(
    [
        ("velocity", "f8", 3),  # [m/s] DVL, body frame
        ("depth", "f8"),  # [m]
        ("yaw", "f8"),  # [rad]
        ("yaw_rate", "f8"),  # [rad/s]
        ("fresh", "f8"),  # not zero when the DVL has just measured, with success
        ("tilt", "f8", 2),  # [rad] roll, pitch
        ("tilt_rates", "f8", 2),  # [rad/s] p, q
    ]
)


@njit(cache=True, error_model="numpy")
def _cut(value: float, low: float, high: float) -> float:
    """Return the value within limits; what is no number stays none."""
    if value < low:
        return low
    return high if value > high else value


@njit(cache=True, error_model="numpy")
def _wrapped(angle: float) -> float:
    """Return the angle within [-pi, pi)."""
    if -math.pi <= angle < math.pi:
        return angle
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


@njit(cache=True, error_model="numpy")
def _drag(axis: Record, velocity: float) -> float:
    """Return the vehicle's drag [N] at a velocity through the water."""
    drag: float = (axis.linear + axis.quadratic * abs(velocity)) * velocity
    return drag


@njit(cache=True, error_model="numpy")
def _force(axis: Record, wanted: float, measured: float, fresh: bool) -> float:
    """Return the force [N] to ask for; `fresh` says that the measurement is new and good."""
    if fresh:
        missed = measured - axis.velocity
        axis.velocity += axis.correct_velocity * missed
        axis.disturbance += axis.correct_force * missed
    feedback: float = axis.gain * (wanted - axis.velocity)
    return _drag(axis, wanted) + feedback - float(axis.disturbance)


@njit(cache=True, error_model="numpy")
def _predict(axis: Record, force: float, dt: float) -> None:
    """Move the estimate on; `force` [N] is what the thrusters were really told to give."""
    axis.thrust += (force - axis.thrust) * (dt / (axis.lag + dt))
    push = axis.thrust + axis.disturbance - _drag(axis, axis.velocity)
    axis.velocity += push * (dt / axis.mass)


@njit(cache=True, error_model="numpy")
def _push(hold: Record, error: float, speed_error: float, dt: float) -> float:
    """Return the force or moment of a PID for an error of the place and of the speed."""
    hold.force += hold.rate * error * dt
    push: float = hold.stiffness * error + hold.friction * speed_error + hold.force
    return push


@njit(cache=True, error_model="numpy")
def _depth_force(hold: Record, heave: float, sensed: Record, dt: float) -> float:
    target = _cut(hold.target + heave * dt, sensed.depth - hold.lead, sensed.depth + hold.lead)
    hold.target = max(target, SHALLOWEST_M)
    return _push(hold, hold.target - sensed.depth, heave - sensed.velocity[HEAVE], dt)


@njit(cache=True, error_model="numpy")
def _yaw_moment(hold: Record, held: bool, rate: float, sensed: Record, dt: float) -> float:
    if not held:
        return 0.0 if rate == 0.0 else hold.friction * (rate - sensed.yaw_rate)
    error = _wrapped(hold.target + rate * dt - sensed.yaw)
    error = _cut(error, -hold.lead, hold.lead)
    hold.target = sensed.yaw + error
    return _push(hold, error, rate - sensed.yaw_rate, dt)


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
def _predict_all(
    axes: Records, choice: Record, directions: Array, thrust: Array, dt: float
) -> None:
    """Tell the observers what the thrusters can really give."""
    for at in range(3):
        force = 0.0
        for i in range(thrust.size):
            share = directions[i, at]
            if share != 0.0:
                force += share * _cut(thrust[i], -choice.reverse, choice.forward)
        _predict(axes[at], force, dt)


@njit(cache=True, error_model="numpy")
def _level_out(holds: Records, allocator: Array, sensed: Record, thrust: Array, dt: float) -> None:
    """Add what brings roll and pitch to zero; a moment, so the forces stay what they are."""
    for at in range(2):
        hold = holds[ROLLING + at]
        error = _cut(-sensed.tilt[at], -hold.lead, hold.lead)
        moment = _push(hold, error, -sensed.tilt_rates[at], dt)
        for i in range(thrust.size):
            thrust[i] += allocator[i, ROLL if at == 0 else PITCH] * moment


@njit(cache=True, error_model="numpy")
def _add_efforts(
    efforts: Array, wanted: tuple[float, float, float], measured: Array, command: Array
) -> None:
    """Add each thruster's effort for the errors of surge, sway and heave."""
    surge, sway, heave = (
        wanted[0] - measured[0],
        wanted[1] - measured[1],
        wanted[2] - measured[2],
    )
    for i in range(command.size):
        effort = efforts[i, SURGE] * surge + efforts[i, SWAY] * sway + efforts[i, HEAVE] * heave
        command[i] = _cut(command[i] + effort, -1.0, 1.0)


@njit(cache=True, error_model="numpy")
def step(
    reference: tuple[float, float, float, float],
    measured: Records,
    dt: float,
    choices: Records,
    axes: Records,
    holds: Records,
    vehicle: tuple[Array, Array, Array, Array],
    out: tuple[Array, Array],
) -> None:
    """Write the thrusters' commands, (n,) in [-1, 1], for one control tick.

    Parameters
    ----------
    reference : surge, sway, heave [m/s], yaw rate [rad/s]
    measured, choices : (1,) records `MEASURED` and `CHOICE`
    dt : [s]
    axes, holds : (3,) and (4,) records `AXIS` and `HOLD`, changed
    vehicle : (n, 6) allocator, (n, 3) thrusters' directions, (n, 3) efforts per m/s of error, (16,)
        packed thruster curve
    out : (n,) thrust [N] and (n,) commands, written
    """
    choice, sensed = choices[0], measured[0]
    allocator, directions, efforts, curve = vehicle
    thrust, command = out
    wanted = (
        _cut(reference[0], -choice.limit, choice.limit),
        _cut(reference[1], -choice.limit, choice.limit),
        _cut(reference[2], -choice.limit, choice.limit),
    )
    rate = _cut(reference[3], -FASTEST_YAW_RAD_S, FASTEST_YAW_RAD_S)
    moment = _yaw_moment(holds[HEADING], choice.hold_heading, rate, sensed, dt)
    if choice.paper:
        down = _depth_force(holds[DEPTH], wanted[HEAVE], sensed, dt) if choice.hold_depth else 0.0
        _share_out(allocator, (0.0, 0.0, down, moment), curve, thrust, command)
        _add_efforts(efforts, wanted, sensed.velocity, command)
        return
    fresh = sensed.fresh != 0.0
    surge = _force(axes[SURGE], wanted[SURGE], sensed.velocity[SURGE], fresh)
    sway = _force(axes[SWAY], wanted[SWAY], sensed.velocity[SWAY], fresh)
    heave = _force(axes[HEAVE], wanted[HEAVE], sensed.velocity[HEAVE], fresh)
    if choice.hold_depth:
        heave = _depth_force(holds[DEPTH], wanted[HEAVE], sensed, dt)
    _share_out(allocator, (surge, sway, heave, moment), curve, thrust, command)
    _predict_all(axes, choice, directions, thrust, dt)
    if choice.hold_tilt:
        _level_out(holds, allocator, sensed, thrust, dt)
        commands_for(thrust, curve, command)
