"""What a vehicle can do, from its numbers alone: forces, speeds, the current that it can hold.

Without the simulator and without a controller: steady thrust against drag along one axis.
"""

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles.model import ThrustCurve, Vehicle

SURGE, SWAY, HEAVE, ROLL, PITCH, YAW = range(6)
BALANCED = (SURGE, SWAY, HEAVE, YAW)  # roll and pitch are left to the righting moment
DIRECTIONS = {  # name -> axis and sign
    "ahead": (SURGE, 1.0),
    "astern": (SURGE, -1.0),
    "to starboard": (SWAY, 1.0),
    "to port": (SWAY, -1.0),
    "down": (HEAVE, 1.0),
    "up": (HEAVE, -1.0),
    "turning to starboard": (YAW, 1.0),
    "turning to port": (YAW, -1.0),
}
SHARE = 1.0 - math.exp(-1.0)  # of a first-order response after its time constant
_NOTHING = 1e-9
_BISECTIONS = 60
_STEP_SHARE = 0.01  # of the shortest time of a response


@dataclass(frozen=True, slots=True)
class Response:
    """What full thrust in one direction leads to; forces in N or N m, speeds in m/s or rad/s."""

    force: float
    speed: float  # at which drag equals the force
    time_s: float  # until 63 % of that speed, from rest


def response(vehicle: Vehicle, direction: str) -> Response:
    """Return the response to full thrust in one of `DIRECTIONS`."""
    axis, sign = DIRECTIONS[direction]
    force = strongest(vehicle, axis, sign)
    speed = speed_at(vehicle, axis, force)
    return Response(force, speed, _rise_s(vehicle, axis, force, speed))


def full_thrust(curve: ThrustCurve) -> tuple[float, float]:
    """Return the thrust [N] of a thruster at full command, forward and reverse, both positive."""
    most_forward, most_reverse = curve.limits.value
    if curve.kind == "quadratic":
        return min(curve.forward.scalar, most_forward), min(curve.reverse.scalar, most_reverse)
    return (
        _thrust_at_full(curve.forward.value, most_forward),
        _thrust_at_full(curve.reverse.value, most_reverse),
    )


def _thrust_at_full(coefficients: tuple[float, ...], most: float) -> float:
    low, high = 0.0, most
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        below = np.polynomial.polynomial.polyval(middle, coefficients) < 1.0
        low, high = (middle, high) if below else (low, middle)
    return high


def strongest(vehicle: Vehicle, axis: int, sign: float) -> float:
    """Return the greatest steady force along an axis with all thrusters within their limits.

    The forces on the other axes of `BALANCED` are zero, and heave carries weight and buoyancy; axes
    on which no thruster acts are left alone. It is 0 if the thrusters cannot do that.
    """
    matrix = vehicle.allocation()
    axes = [one for one in BALANCED if np.abs(matrix[one]).max() > _NOTHING]
    if axis not in axes:
        return 0.0
    wanted, carried = np.zeros(6), np.zeros(6)
    wanted[axis] = sign
    carried[HEAVE] = vehicle.buoyancy.scalar - vehicle.weight.scalar
    thrusts = full_thrust(vehicle.curve)
    matrix, wanted, carried = matrix[axes], wanted[axes], carried[axes]
    weight = float(np.linalg.norm(carried))
    if weight > 0.0 and _reach(matrix, carried / weight, np.zeros_like(carried), thrusts) < weight:
        return 0.0
    return _reach(matrix, wanted, carried, thrusts)


def _reach(matrix: Array, wanted: Array, carried: Array, thrusts: tuple[float, float]) -> float:
    """Return the greatest t >= 0 with `matrix` f = t `wanted` + `carried` for thrusts f in limits.

    By the dual of this linear programme: the least support value over all normals of the set of
    wrenches that meet `wanted`. Its vertices are orthogonal to as many thrusters as there are axes
    but one.
    """
    basis = _range_of(matrix)
    for vector in (wanted, carried):
        if np.abs(vector - basis @ (basis.T @ vector)).max() > _NOTHING:
            return 0.0
    matrix, wanted, carried = basis.T @ matrix, basis.T @ wanted, basis.T @ carried
    axes, thrusters = matrix.shape
    chosen = np.array(list(combinations(range(thrusters), axes - 1)), dtype=int)
    orthogonal = matrix.T[chosen].reshape(len(chosen), axes - 1, axes)
    systems = np.concatenate([np.tile(wanted, (len(chosen), 1, 1)), orthogonal], axis=1)
    systems = systems[np.abs(np.linalg.det(systems)) > _NOTHING]
    right = np.zeros((len(systems), axes, 1))
    right[:, 0] = 1.0
    normals = np.linalg.solve(systems, right)[..., 0]
    pulls = normals @ matrix
    forward, reverse = thrusts
    support = np.where(pulls > 0.0, forward * pulls, -reverse * pulls).sum(axis=1)
    return max(0.0, float((support - normals @ carried).min(initial=np.inf)))


def _range_of(matrix: Array) -> Array:
    """Return an orthonormal basis of the columns, (axes, rank)."""
    left, sizes, _ = np.linalg.svd(matrix, full_matrices=False)
    return np.asarray(left[:, sizes > _NOTHING])


def speed_at(vehicle: Vehicle, axis: int, force: float) -> float:
    """Return the speed at which drag along an axis equals a force; infinite without drag."""
    linear, quadratic = _drag(vehicle, axis)
    if force == 0.0:
        return 0.0
    if linear == quadratic == 0.0:
        return math.inf
    return 2.0 * force / (linear + math.sqrt(linear**2 + 4.0 * quadratic * force))


def _drag(vehicle: Vehicle, axis: int) -> tuple[float, float]:
    return float(vehicle.linear_drag()[axis]), float(vehicle.quadratic_drag()[axis])


def _rise_s(vehicle: Vehicle, axis: int, force: float, final: float) -> float:
    """Return the time [s] until `SHARE` of the final speed, with the lag of the thrusters."""
    if not 0.0 < final < math.inf:
        return math.nan
    mass = float((vehicle.mass_rigid() + vehicle.mass_added())[axis, axis])
    lag = vehicle.lag.scalar
    linear, quadratic = _drag(vehicle, axis)
    step = _STEP_SHARE * max(lag, mass * final / force)
    speed, t = 0.0, 0.0
    while speed < SHARE * final:
        thrust = force * (1.0 - math.exp(-(t + 0.5 * step) / lag))
        middle = speed + 0.5 * step * (thrust - (linear + quadratic * speed) * speed) / mass
        speed += step * (thrust - (linear + quadratic * middle) * middle) / mass
        t += step
    return t


def righting_n_m(vehicle: Vehicle) -> float:
    """Return the righting moment [N m] for each radian of roll or pitch; positive is stable."""
    gravity, buoyancy = vehicle.centre_of_gravity.value[2], vehicle.centre_of_buoyancy.value[2]
    return vehicle.weight.scalar * gravity - vehicle.buoyancy.scalar * buoyancy


def period_s(vehicle: Vehicle, axis: int) -> float:
    """Return the period [s] in which roll or pitch swings, without damping; NaN if it does not."""
    inertia = float((vehicle.mass_rigid() + vehicle.mass_added())[axis, axis])
    stiffness = righting_n_m(vehicle)
    return 2.0 * math.pi * math.sqrt(inertia / stiffness) if stiffness > 0.0 else math.nan


def munk_speed(vehicle: Vehicle) -> float:
    """Return the speed ahead [m/s] from which the Munk moment tilts the vehicle despite gravity."""
    added = vehicle.mass_added()
    excess = float(added[HEAVE, HEAVE] - added[SURGE, SURGE])
    return math.sqrt(max(righting_n_m(vehicle), 0.0) / excess) if excess > 0.0 else math.inf


def bounding_box(vehicle: Vehicle) -> tuple[Array, Array]:
    """Return the lowest and the highest corner of the whole hull, (3,) each [m]."""
    low = [np.subtract(one.centre.value, np.multiply(0.5, one.size.value)) for one in vehicle.hull]
    high = [np.add(one.centre.value, np.multiply(0.5, one.size.value)) for one in vehicle.hull]
    return np.min(low, axis=0), np.max(high, axis=0)
