"""The arithmetic of the velocity controller, compiled: it runs at every control step.

Its state is in NumPy records: three translational axes, four holds, the settings. All functions
update their records in place.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.control.allocation import HEAVE, PITCH, ROLL, SURGE, SWAY, YAW
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.thrusters import commands_for

Records = NDArray[np.void]
Record = Any  # one of them; Numba reads its fields as attributes

DEPTH, HEADING, ROLLING, PITCHING = range(4)  # indices of the holds
SHALLOWEST_M = 0.5  # [m] limit of the depth hold; the equations have no water surface
FASTEST_YAW_RAD_S = 0.6  # [rad/s] S: COLA2's open-loop limit of the Girona 500

AXIS = np.dtype(
    [
        ("linear", "f8"),  # [N s/m] the vehicle's drag
        ("quadratic", "f8"),  # [N s²/m²]
        ("mass", "f8"),  # [kg] with added mass
        ("lag", "f8"),  # [s] the thrusters'
        ("gain", "f8"),  # [N s/m]
        ("correct_velocity", "f8"),  # [1] gain on the prediction error
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
        ("lead", "f8"),  # [m, rad] largest distance of the set point from the vehicle
        ("target", "f8"),  # [m, rad]
        ("force", "f8"),  # [N, N m] the integral's part
    ]
)
SETTINGS = np.dtype(
    [
        ("paper", "?"),  # effort proportional to the velocity error, as published
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
        ("fresh", "f8"),  # nonzero if the DVL has a new valid reading
        ("tilt", "f8", 2),  # [rad] roll, pitch
        ("tilt_rates", "f8", 2),  # [rad/s] p, q
    ]
)


class Reference(NamedTuple):
    """What the vehicle should do."""

    surge: float  # [m/s]
    sway: float
    heave: float
    yaw_rate: float  # [rad/s]


class Thrusters(NamedTuple):
    """What the controller knows of the thrusters."""

    allocator: Array  # (n, 6)
    directions: Array  # (n, 3)
    efforts: Array  # (n, 3) per m/s of error
    curve: Array  # (16,) packed


class Outputs(NamedTuple):
    """What a control step writes."""

    thrust: Array  # (n,) [N] wanted
    command: Array  # (n,) in [-1, 1]


@njit(cache=True, error_model="numpy")
def _clip(value: float, low: float, high: float) -> float:
    """Return the value clipped to limits; NaN stays NaN."""
    if value < low:
        return low
    return high if value > high else value


@njit(cache=True, error_model="numpy")
def _wrap(angle: float) -> float:
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
    """Return the desired force [N]; `fresh` tells whether the measurement is new and valid."""
    if fresh:
        error = measured - axis.velocity
        axis.velocity += axis.correct_velocity * error
        axis.disturbance += axis.correct_force * error
    feedback: float = axis.gain * (wanted - axis.velocity)
    return _drag(axis, wanted) + feedback - float(axis.disturbance)


@njit(cache=True, error_model="numpy")
def _predict(axis: Record, force: float, dt: float) -> None:
    """Predict the estimate; `force` [N] is the saturated command of the thrusters."""
    axis.thrust += (force - axis.thrust) * (dt / (axis.lag + dt))
    push = axis.thrust + axis.disturbance - _drag(axis, axis.velocity)
    axis.velocity += push * (dt / axis.mass)


@njit(cache=True, error_model="numpy")
def _pid(hold: Record, error: float, speed_error: float, dt: float) -> float:
    """Return the force or moment of a PID for an error of position and of speed."""
    hold.force += hold.rate * error * dt
    push: float = hold.stiffness * error + hold.friction * speed_error + hold.force
    return push


@njit(cache=True, error_model="numpy")
def _depth_force(hold: Record, heave: float, sensed: Record, dt: float) -> float:
    target = _clip(hold.target + heave * dt, sensed.depth - hold.lead, sensed.depth + hold.lead)
    hold.target = max(target, SHALLOWEST_M)
    return _pid(hold, hold.target - sensed.depth, heave - sensed.velocity[HEAVE], dt)


@njit(cache=True, error_model="numpy")
def _yaw_moment(hold: Record, held: bool, rate: float, sensed: Record, dt: float) -> float:
    if not held:
        return 0.0 if rate == 0.0 else hold.friction * (rate - sensed.yaw_rate)
    error = _wrap(hold.target + rate * dt - sensed.yaw)
    error = _clip(error, -hold.lead, hold.lead)
    hold.target = sensed.yaw + error
    return _pid(hold, error, rate - sensed.yaw_rate, dt)


@njit(cache=True, error_model="numpy")
def _allocate(
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
    axes: Records, setting: Record, directions: Array, thrust: Array, dt: float
) -> None:
    """Predict all axes with the saturated thrusts."""
    for at in range(3):
        force = 0.0
        for i in range(thrust.size):
            share = directions[i, at]
            if share != 0.0:
                force += share * _clip(thrust[i], -setting.reverse, setting.forward)
        _predict(axes[at], force, dt)


@njit(cache=True, error_model="numpy")
def _hold_tilt(holds: Records, allocator: Array, sensed: Record, thrust: Array, dt: float) -> None:
    """Add the moment that brings roll and pitch to zero; it leaves the forces unchanged."""
    for at in range(2):
        hold = holds[ROLLING + at]
        error = _clip(-sensed.tilt[at], -hold.lead, hold.lead)
        moment = _pid(hold, error, -sensed.tilt_rates[at], dt)
        for i in range(thrust.size):
            thrust[i] += allocator[i, ROLL if at == 0 else PITCH] * moment


@njit(cache=True, error_model="numpy")
def _add_paper_efforts(
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
        command[i] = _clip(command[i] + effort, -1.0, 1.0)


@njit(cache=True, error_model="numpy")
def step(
    reference: Reference,
    measured: Records,
    dt: float,
    settings: Records,
    axes: Records,
    holds: Records,
    thrusters: Thrusters,
    out: Outputs,
) -> None:
    """Write the thrusters' commands for one control step.

    Parameters
    ----------
    measured, settings : (1,) records `MEASURED` and `SETTINGS`
    dt : [s]
    axes, holds : (3,) and (4,) records `AXIS` and `HOLD`, changed
    """
    setting, sensed = settings[0], measured[0]
    allocator, curve = thrusters.allocator, thrusters.curve
    thrust, command = out.thrust, out.command
    wanted = (
        _clip(reference.surge, -setting.limit, setting.limit),
        _clip(reference.sway, -setting.limit, setting.limit),
        _clip(reference.heave, -setting.limit, setting.limit),
    )
    rate = _clip(reference.yaw_rate, -FASTEST_YAW_RAD_S, FASTEST_YAW_RAD_S)
    moment = _yaw_moment(holds[HEADING], setting.hold_heading, rate, sensed, dt)
    if setting.paper:
        down = _depth_force(holds[DEPTH], wanted[HEAVE], sensed, dt) if setting.hold_depth else 0.0
        _allocate(allocator, (0.0, 0.0, down, moment), curve, thrust, command)
        _add_paper_efforts(thrusters.efforts, wanted, sensed.velocity, command)
        return
    fresh = sensed.fresh != 0.0
    surge = _force(axes[SURGE], wanted[SURGE], sensed.velocity[SURGE], fresh)
    sway = _force(axes[SWAY], wanted[SWAY], sensed.velocity[SWAY], fresh)
    heave = _force(axes[HEAVE], wanted[HEAVE], sensed.velocity[HEAVE], fresh)
    if setting.hold_depth:
        heave = _depth_force(holds[DEPTH], wanted[HEAVE], sensed, dt)
    _allocate(allocator, (surge, sway, heave, moment), curve, thrust, command)
    _predict_all(axes, setting, thrusters.directions, thrust, dt)
    if setting.hold_tilt:
        _hold_tilt(holds, allocator, sensed, thrust, dt)
        commands_for(thrust, curve, command)
