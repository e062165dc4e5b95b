"""What surface waves do below them: linear theory and the JONSWAP spectrum.

    S(f) ~ f^-5 exp(-5/4 (f/fp)^-4) g^exp(-(f/fp - 1)² / (2 s²))

with g = 3.3 and s = 0.07 below the peak fp, 0.09 above

(Hasselmann et al. 1973; DNV-RP-C205 3.5.5), scaled to its significant height. At the height h above
a bottom in water of depth d, a wave of amplitude a, wave number k and angular frequency w moves the
water by a w cosh(kh)/sinh(kd) cos(wt - p) along its way and by a w sinh(kh)/sinh(kd) sin(wt - p)
down, with w² = g k tanh(kd). All of them come from one direction. What is left out: that the
current shortens or stretches them, and their drift, which is of second order.

The table has the waves at the start's place. A vehicle that is x metres further along their way
meets them earlier or later by kx radians: with waves of 4 s in 5 m of water (k = 0.28 rad/m), by
0.08 rad at 0.3 m.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import PI, exp, log
from seamark.sim.physics.current import TABLE_GRID_S
from seamark.sim.physics.water_motion.harmonics import sinusoids
from seamark.sim.vehicles import STANDARD_GRAVITY

SINUSOIDS = 96
_PEAKEDNESS = 3.3  # S: Hasselmann et al. 1973, the mean of JONSWAP
_BAND = (0.5, 4.0)  # of the frequency relative to the peak's; 99 % of the variance, E
_STEPS = 60  # of the bisection for a wave number: to the last bit


class Waves(NamedTuple):
    """A sea state."""

    height_m: float  # significant
    period_s: float  # of the spectrum's peak


def orbital_velocity(
    waves: Waves, heights: Array, depth_m: float, rng: np.random.Generator, count: int
) -> Array:
    """Return the water's velocity along the waves' way and down, (k, 2, count) [m/s].

    Parameters
    ----------
    heights : (k,) [m]
        Above the bottom.
    depth_m
        Of the water.
    """
    places, turns = rng.random((2, SINUSOIDS))
    peak = 1.0 / waves.period_s
    width = (_BAND[1] - _BAND[0]) * peak / SINUSOIDS
    frequencies = _BAND[0] * peak + width * (np.arange(SINUSOIDS) + places)
    speeds = 2.0 * PI * frequencies * amplitudes_of(waves, frequencies)
    sizes = np.empty((SINUSOIDS, heights.size, 2))
    _write_sizes(frequencies, speeds, heights, depth_m, sizes)
    phases = np.empty_like(sizes)
    phases[:, :, 0] = -2.0 * PI * turns[:, None]
    phases[:, :, 1] = phases[:, :, 0] - 0.5 * PI  # a sine
    rows = sizes.reshape(SINUSOIDS, -1), phases.reshape(SINUSOIDS, -1)
    both = sinusoids(frequencies, *rows, step_s=TABLE_GRID_S, count=count)
    return both.reshape(heights.size, 2, count)


@njit(cache=True, error_model="numpy")
def _write_sizes(
    frequencies: Array, speeds: Array, heights: Array, depth_m: float, out: Array
) -> None:
    """Write how fast each wave moves the water along its way and down, (n, k, 2) [m/s]."""
    for i in range(frequencies.size):
        k = wave_number(2.0 * PI * frequencies[i], depth_m)
        for h in range(heights.size):
            out[i, h, 0] = speeds[i] * _share(k, heights[h], depth_m, 1.0)
            out[i, h, 1] = speeds[i] * _share(k, heights[h], depth_m, -1.0)


@njit(cache=True, error_model="numpy")
def jonswap(frequency: float, peak: float) -> float:
    """Return the spectrum at a frequency [Hz] without its scale."""
    ratio = frequency / peak
    spread = 0.07 if ratio <= 1.0 else 0.09
    off = (ratio - 1.0) / spread
    enhancement = exp(log(_PEAKEDNESS) * exp(-0.5 * off * off))
    return exp(-5.0 * log(ratio) - 1.25 * exp(-4.0 * log(ratio))) * enhancement


def amplitudes_of(waves: Waves, frequencies: Array) -> Array:
    """Return the amplitude of each sinusoid, (n,) [m]: their variance is height² / 16."""
    power = [jonswap(f, 1.0 / waves.period_s) for f in frequencies.tolist()]
    total = 0.0
    for one in power:
        total += one
    return waves.height_m / 4.0 * np.sqrt(2.0 * np.array(power) / total)


@njit(cache=True, error_model="numpy")
def wave_number(rate: float, depth_m: float) -> float:
    """Return k [rad/m] of the angular frequency [rad/s] in water of a depth: by bisection."""
    deep = rate * rate / STANDARD_GRAVITY
    # k tanh(kd) = deep lies between the deep and the sum of the deep and the shallow solution.
    low, high = deep, deep + math.sqrt(deep / depth_m)
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        e = exp(-2.0 * middle * depth_m)
        if middle * (1.0 - e) / (1.0 + e) < deep:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@njit(cache=True, error_model="numpy")
def _share(k: float, height: float, depth_m: float, sign: float) -> float:
    """Return cosh(kh)/sinh(kd), or with a negative sign sinh(kh)/sinh(kd), without overflow."""
    below = exp(k * (height - depth_m))
    return float(below * (1.0 + sign * exp(-2.0 * k * height)) / (1.0 - exp(-2.0 * k * depth_m)))
