"""Turbulence that the mean current carries past: von Karman's spectra (ESDU 85020).

With the integral time scale T = L / U of a length scale L and the frequency f:

    along the current   S(f) = 4 s² T / (1 + 70.8 (f T)²)^(5/6)
    across and upright  S(f) = 4 s² t (1 + 755.2 (f t)²) / (1 + 283.2 (f t)²)^(11/6),  t = T / 2

Both fall as f^(-5/3). s is the standard deviation. The correlation along the current is

    r(x) = 2^(2/3) / Gamma(1/3) (x / (1.339 T))^(1/3) K_1/3(x / (1.339 T)).

The spectrum is that of the water at a point. Eddies smaller than a vehicle, faster than about U
divided by its length, push its parts in different directions in truth; here they push all of it.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import PI, exp, log
from seamark.sim.physics.current import TABLE_GRID_S
from seamark.sim.physics.water_motion.harmonics import sinusoids
from seamark.sim.physics.water_motion.places import ACROSS, LENGTH_PER_HEIGHT, UPRIGHT, Place

SINUSOIDS = 256
# Lowest frequency relative to 1/T: 0.8 % of the variance lies below it.
_LOWEST = 0.002
HIGHEST_HZ = 0.45 / TABLE_GRID_S  # a little below what the grid can show
_LEAST_SPEED = 0.02  # [m/s] slower water takes no eddy past within a level


class Turbulence(NamedTuple):
    """Standard deviations [m/s] along, across and upright, and the integral time scale [s]."""

    along: float
    across: float
    upright: float
    time_s: float


def spectrum_along(frequency: Array, sigma: float, time_s: float) -> Array:
    """Return S along the current at frequencies (n,) [Hz], (n,) [m²/s² per Hz]."""
    x = frequency * time_s
    return 4.0 * sigma * sigma * time_s * _power(1.0 + 70.8 * x * x, -5.0 / 6.0)


def spectrum_across(frequency: Array, sigma: float, time_s: float) -> Array:
    """Return S across the current and upright at frequencies (n,) [Hz], (n,) [m²/s² per Hz]."""
    half = 0.5 * time_s
    x = frequency * half
    shape = (1.0 + 755.2 * x * x) * _power(1.0 + 283.2 * x * x, -11.0 / 6.0)
    return 4.0 * sigma * sigma * half * shape


def fluctuation(turbulence: Turbulence, rng: np.random.Generator, count: int) -> Array:
    """Return the turbulent velocity along, across and down on a table's grid, (3, count) [m/s].

    Each is a sum of sinusoids, one somewhere in each of equal bins of log f. A longer one begins
    with the same values.
    """
    places, turns = rng.random(SINUSOIDS), rng.random((SINUSOIDS, 3))  # whatever the place
    lowest = _LOWEST / turbulence.time_s
    width = log(HIGHEST_HZ / lowest) / SINUSOIDS
    frequencies = _exponentials(width * (np.arange(SINUSOIDS) + places)) * lowest
    sizes = np.empty((SINUSOIDS, 3))
    for axis, sigma in enumerate((turbulence.along, turbulence.across, turbulence.upright)):
        formula = spectrum_across if axis else spectrum_along
        sizes[:, axis] = sigma * _amplitudes(frequencies, formula, turbulence.time_s)
    return sinusoids(frequencies, sizes, 2.0 * PI * turns, step_s=TABLE_GRID_S, count=count)


def turbulence_of(place: Place, speed: float, height_m: float) -> Turbulence:
    """Return the turbulence of a mean current [m/s] at a height above the bottom of a place [m].

    Still water has none.
    """
    strong, weak = place.intensity * speed, place.floor_m_s
    sigma = float(np.sqrt(strong * strong + weak * weak)) if speed > 0.0 else 0.0
    time_s = LENGTH_PER_HEIGHT * height_m / max(speed, _LEAST_SPEED)
    return Turbulence(sigma, ACROSS * sigma, UPRIGHT * sigma, time_s)


def _amplitudes(
    frequencies: Array, formula: Callable[[Array, float, float], Array], time_s: float
) -> Array:
    """Return amplitudes (n,) of a spectrum on equal bins of log f, for a deviation of one."""
    power = formula(frequencies, 1.0, time_s) * frequencies  # times the bin's width in log f
    amplitudes: Array = np.sqrt(2.0 * power / math.fsum(power.tolist()))
    return amplitudes


@njit(cache=True, error_model="numpy")
def _power(base: Array, exponent: float) -> Array:
    """Return positive numbers (n,) to a power; NumPy's own depends on the processor."""
    out = np.empty_like(base)
    for i in range(base.size):
        out[i] = exp(exponent * log(base[i]))
    return out


@njit(cache=True, error_model="numpy")
def _exponentials(values: Array) -> Array:
    out = np.empty_like(values)
    for i in range(values.size):
        out[i] = exp(values[i])
    return out
