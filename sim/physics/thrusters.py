"""Thrusters: from the command in [-1, 1] to the steady thrust [N], and back.

The first-order lag between steady and present thrust is part of the plant's equations. From command
to thrust everything is for one thruster or, with `numerics.lanes`, for one of eight vehicles each.
"""

import math

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.lanes import like, select, some
from seamark.sim.vehicles import ThrustCurve

Terms = tuple[float, float, float, float, float, float]
# Indices in the array of a packed curve.
_KIND, _DEAD_BAND, _MOST_FORWARD, _MOST_REVERSE, _FORWARD, _REVERSE = 0, 1, 2, 3, 4, 10
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


@njit(cache=True, error_model="numpy", inline="always")
def _terms(curve: Array, forward: bool) -> Terms:
    """Return the curve's coefficients for thrust in one direction."""
    return (
        select(forward, curve[_FORWARD], curve[_REVERSE]),
        select(forward, curve[_FORWARD + 1], curve[_REVERSE + 1]),
        select(forward, curve[_FORWARD + 2], curve[_REVERSE + 2]),
        select(forward, curve[_FORWARD + 3], curve[_REVERSE + 3]),
        select(forward, curve[_FORWARD + 4], curve[_REVERSE + 4]),
        select(forward, curve[_FORWARD + 5], curve[_REVERSE + 5]),
    )


@njit(cache=True, error_model="numpy", inline="always")
def _polynomial(terms: Terms, force: float) -> float:
    a, b, c, d, e, f = terms
    return ((((f * force + e) * force + d) * force + c) * force + b) * force + a


@njit(cache=True, error_model="numpy", inline="always")
def _slope(terms: Terms, force: float) -> float:
    _a, b, c, d, e, f = terms
    return (((5.0 * f * force + 4.0 * e) * force + 3.0 * d) * force + 2.0 * c) * force + b


@njit(cache=True, error_model="numpy")
def _invert(terms: Terms, most: float, effort: float) -> float:
    """Return the thrust in [0, most] at which the polynomial gives `effort`."""
    low, high = like(effort, 0.0), most
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        below = _polynomial(terms, middle) < effort
        low, high = select(below, middle, low), select(below, high, middle)
    force = 0.5 * (low + high)
    for _ in range(_NEWTON_STEPS):
        force = force - (_polynomial(terms, force) - effort) / _slope(terms, force)
    return select(force < 0.0, 0.0, select(force > most, most, force))


@njit(cache=True, error_model="numpy")
def thrust_from_command(command: float, curve: Array) -> float:
    """Return the steady thrust [N] of one command; commands beyond ±1 count as ±1."""
    effort = select(abs(command) < 1.0, abs(command), 1.0)
    forward = command > 0.0
    terms = _terms(curve, forward)
    most = select(forward, curve[_MOST_FORWARD], curve[_MOST_REVERSE])
    force = terms[0] * effort * effort
    force = select(force < most, force, most)
    pushes = effort > curve[_DEAD_BAND]
    polynomial = pushes & (curve[_KIND] != _QUADRATIC)
    if some(polynomial):
        force = select(polynomial, _invert(terms, most, effort), force)
    return select(pushes, select(forward, force, -force), 0.0)


@njit(cache=True, error_model="numpy")
def command_from_thrust(force: float, curve: Array) -> float:
    """Return the command in [-1, 1] whose steady thrust is nearest to `force` [N]."""
    if force == 0.0:
        return 0.0
    terms = _terms(curve, force > 0.0)
    size = min(abs(force), curve[_MOST_FORWARD] if force > 0.0 else curve[_MOST_REVERSE])
    if curve[_KIND] == _QUADRATIC:
        effort = math.sqrt(size / terms[0])
    else:
        effort = _polynomial(terms, size)
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
