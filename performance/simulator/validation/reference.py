"""A second, independent simulator: SciPy, Euler angles, Fossen's matrices.

It shares with `sim` the vehicle parameters and the mass and allocation matrices computed from them,
but no equation of motion: rotations are composed of three elementary ones instead of a quaternion,
C(v) is built from the blocks of the mass matrix, thrust curves are inverted by Brent's method, and
an adaptive Dormand-Prince 8(5,3) solver integrates. For tests and validation; too slow for runs.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import scipy  # its parts are loaded when they are used

from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles import STANDARD_GRAVITY, Vehicle

FORCE = 410.0 * 0.134  # [N s²/m²] S and D: the published body force, see sim/physics/current.py


class Leg(NamedTuple):
    """One leg of a manoeuvre: its duration and constant thruster commands, (n,) in [-1, 1]."""

    seconds: float
    command: Array


class Water(NamedTuple):
    """The current without gusts: its level [m/s], the direction it comes from [rad], and its law.

    With an exponent n, the speed at depth z [m] is scaled by ((bottom - z) / height)^n.
    """

    level: float
    azimuth: float
    force: bool
    exponent: float = 0.0
    bottom: float = 0.0
    height: float = 1.0


def skew(vector: Array) -> Array:
    """Return the skew-symmetric matrix S with S b = vector x b."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation_matrix(angles: Array) -> Array:
    """Return the rotation matrix from body to world, composed of three elementary rotations."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles), np.sin(angles)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    rotation: Array = about_z @ about_y @ about_x
    return rotation


def coriolis(mass: Array, velocity: Array) -> Array:
    """Return Fossen's C(v), (6, 6), from the blocks of the mass matrix."""
    a = mass[:3, :3] @ velocity[:3] + mass[:3, 3:] @ velocity[3:]
    b = mass[3:, :3] @ velocity[:3] + mass[3:, 3:] @ velocity[3:]
    return np.block([[np.zeros((3, 3)), -skew(a)], [-skew(a), -skew(b)]])


def euler_rates(angles: Array, rates: Array) -> Array:
    """Return the rates of roll, pitch and yaw, (3,) [rad/s], for body rates p, q, r."""
    roll, pitch, _yaw = angles
    p, q, r = rates
    s = q * np.sin(roll) + r * np.cos(roll)  # yaw rate times cos(pitch)
    return np.array([p + s * np.tan(pitch), q * np.cos(roll) - r * np.sin(roll), s / np.cos(pitch)])


def current(t: float, water: Water) -> tuple[Array, Array, Array]:
    """Return the water's velocity and acceleration, (3,) NED, and the body force, (6,) [N]."""
    w1, w2 = 2 * np.pi / 4, 2 * np.pi / 30
    v, dv = water.level + 0.005 * np.sin(w1 * t), 0.005 * w1 * np.cos(w1 * t)
    swing, dswing = 0.7 * np.sin(w2 * t), 0.7 * w2 * np.cos(w2 * t)
    if water.force:
        push = FORCE * np.array([(v * np.sin(swing)) ** 2, v**2, 0, 0, 0, 0])
        return np.zeros(3), np.zeros(3), push
    a = water.azimuth + swing
    along, across = np.array([np.cos(a), np.sin(a), 0.0]), np.array([-np.sin(a), np.cos(a), 0.0])
    return -v * along, -dv * along - v * dswing * across, np.zeros(6)


def thrust_of(vehicle: Vehicle, command: float) -> float:
    """Return the steady thrust [N] of one command."""
    curve, effort = vehicle.curve, abs(command)
    if effort <= curve.dead_band.scalar:
        return 0.0
    forward = command > 0.0
    terms = (curve.forward if forward else curve.reverse).value
    most = curve.limits.value[0 if forward else 1]
    if curve.kind == "quadratic":
        size = min(terms[0] * effort**2, most)
    elif np.polynomial.Polynomial(terms)(most) <= effort:
        size = most
    else:
        size = scipy.optimize.brentq(
            np.polynomial.Polynomial(terms - np.eye(len(terms))[0] * effort), 0.0, most
        )
    return float(np.copysign(size, command))


def reference(vehicle: Vehicle, start: Array, legs: Sequence[Leg], water: Water) -> Array:
    """Return pose, velocity over ground and thrusts after a manoeuvre, (12 + n,).

    Parameters
    ----------
    start : (6,) [m, rad]
        Pose at rest with the thrusters stopped: x, y, z, roll, pitch, yaw.
    """
    state, start_s = np.concatenate((start, np.zeros(6 + len(vehicle.thrusters)))), 0.0
    for leg in legs:
        target = np.array([thrust_of(vehicle, float(value)) for value in leg.command])
        rate = _rate_of(vehicle, target, water)
        steps_and_gate = (start_s, start_s + leg.seconds)
        answer = scipy.integrate.solve_ivp(
            rate, steps_and_gate, state, method="DOP853", rtol=1e-11, atol=1e-12
        )
        state, start_s = np.asarray(answer.y[:, -1]), steps_and_gate[1]
    return state


def _rate_of(vehicle: Vehicle, target: Array, water: Water) -> Callable[[float, Array], Array]:
    rigid, added = vehicle.mass_rigid(), vehicle.mass_added()
    inverse_mass = np.linalg.inv(rigid + added)
    weight, buoyancy = vehicle.weight.scalar, vehicle.buoyancy.scalar
    centres = (vehicle.centre_of_gravity, vehicle.centre_of_buoyancy)
    gravity_centre, buoyancy_centre = (np.array(centre.value) for centre in centres)

    def rate(t: float, y: Array) -> Array:
        angles, nu, thrust = y[3:6], y[6:12], y[12:]
        rotation = rotation_matrix(angles)
        flow, flow_rate, push = current(t, water)
        shear = np.zeros(3)
        if water.exponent:
            height = water.bottom - y[2]
            share = (height / water.height) ** water.exponent
            sinking = (rotation @ nu[:3])[2]
            shear = -flow * water.exponent * share / height * sinking
            flow, flow_rate = share * flow, share * flow_rate
        carried = np.concatenate((rotation.T @ flow, np.zeros(3)))
        relative = nu - carried
        down = rotation.T @ (np.array([0.0, 0.0, 1.0]) - flow_rate / STANDARD_GRAVITY)
        moment = np.cross(weight * gravity_centre - buoyancy * buoyancy_centre, down)
        restoring = np.concatenate(((weight - buoyancy) * down, moment))
        drag = vehicle.linear_drag() + vehicle.quadratic_drag() * np.abs(relative)
        total = vehicle.allocation() @ thrust + push + restoring - drag * relative
        total -= coriolis(rigid, relative) @ relative + coriolis(added, relative) @ relative
        # The change of the current along the vehicle's path in depth acts on the added mass alone.
        total += added @ np.concatenate((rotation.T @ shear, np.zeros(3)))
        acceleration = inverse_mass @ total
        acceleration[:3] += rotation.T @ flow_rate - np.cross(nu[3:], carried[:3])
        lag = (target - thrust) / vehicle.lag.scalar
        return np.concatenate((rotation @ nu[:3], euler_rates(angles, nu[3:]), acceleration, lag))

    return rate
