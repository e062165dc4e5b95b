"""Thrusters: from the command in [-1, 1] to the steady thrust [N], and back.

The first-order lag between steady and present thrust is part of the plant's equations.
"""

import math

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles import ThrustCurve

# Indices in the array of a packed curve.
_KIND, _DEAD_BAND, _MOST_FORWARD, _MOST_REVERSE, _FORWARD, _REVERSE = 0, 1, 2, 3, 4, 10
_TERMS = 6
_QUADRATIC, _POLYNOMIAL = 0.0, 1.0
# Bisection until Newton's method is sure to converge (105 N / 2**14 is 6 mN), then Newton with
# quadratic convergence. Fixed counts give the same bits everywhere.
_BISECTIONS = 14
_NEWTON_STEPS = 3


def pack_curve(curve: ThrustCurve) -> Array:
    """Return a curve as the (16,) array that the functions below read."""
    array = np.zeros(16)
    array[_KIND] = _QUADRATIC if curve.kind == "quadratic" else _POLYNOMIAL
    array[_DEAD_BAND] = curve.dead_band.scalar
    array[_MOST_FORWARD], array[_MOST_REVERSE] = curve.limits.value
    array[_FORWARD : _FORWARD + len(curve.forward.value)] = curve.forward.value
    array[_REVERSE : _REVERSE + len(curve.reverse.value)] = curve.reverse.value
    return array


@njit(cache=True, error_model="numpy")
def _polynomial(curve: Array, first: int, force: float) -> float:
    value = 0.0
    for i in range(_TERMS - 1, -1, -1):
        value = value * force + curve[first + i]
    return value


@njit(cache=True, error_model="numpy")
def _slope(curve: Array, first: int, force: float) -> float:
    value = 0.0
    for i in range(_TERMS - 1, 0, -1):
        value = value * force + i * curve[first + i]
    return value


@njit(cache=True, error_model="numpy")
def _invert(curve: Array, first: int, most: float, effort: float) -> float:
    """Return the thrust in [0, most] at which the polynomial gives `effort`."""
    low, high = 0.0, most
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if _polynomial(curve, first, middle) < effort:
            low = middle
        else:
            high = middle
    force: float = 0.5 * (low + high)
    for _ in range(_NEWTON_STEPS):
        force -= (_polynomial(curve, first, force) - effort) / _slope(curve, first, force)
    if force < 0.0:
        return 0.0
    return most if force > most else force


@njit(cache=True, error_model="numpy")
def thrust_from_command(command: float, curve: Array) -> float:
    """Return the steady thrust [N] of one command; commands beyond ±1 count as ±1."""
    effort = min(abs(command), 1.0)
    if effort <= curve[_DEAD_BAND]:
        return 0.0
    first, most = (
        (_FORWARD, curve[_MOST_FORWARD]) if command > 0.0 else (_REVERSE, curve[_MOST_REVERSE])
    )
    force: float
    if curve[_KIND] == _QUADRATIC:
        force = min(curve[first] * effort * effort, most)
    else:
        force = _invert(curve, first, most, effort)
    return force if command > 0.0 else -force


@njit(cache=True, error_model="numpy")
def command_from_thrust(force: float, curve: Array) -> float:
    """Return the command in [-1, 1] whose steady thrust is nearest to `force` [N]."""
    if force == 0.0:
        return 0.0
    first, most = (
        (_FORWARD, curve[_MOST_FORWARD]) if force > 0.0 else (_REVERSE, curve[_MOST_REVERSE])
    )
    size = min(abs(force), most)
    if curve[_KIND] == _QUADRATIC:
        effort = math.sqrt(size / curve[first])
    else:
        effort = _polynomial(curve, first, size)
    effort = min(effort, 1.0)
    return effort if force > 0.0 else -effort


@njit(cache=True, error_model="numpy")
def steady_thrust(command: Array, curve: Array, out: Array) -> bool:
    """Write the steady thrust of each command, (n,) in [-1, 1], to `out`, (n,) [N].

    Stops and returns False at a command that is not a number.
    """
    for i in range(command.size):
        if math.isnan(command[i]):
            return False
        out[i] = thrust_from_command(command[i], curve)
    return True


@njit(cache=True, error_model="numpy")
def commands_for(force: Array, curve: Array, out: Array) -> None:
    """Write the command for each desired thrust, (n,) [N], to `out`, (n,) in [-1, 1]."""
    for i in range(force.size):
        out[i] = command_from_thrust(force[i], curve)
