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

from typing import NamedTuple

import numpy as np

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
    amplitudes = amplitudes_of(waves, frequencies)
    numbers = np.array([wave_number(2.0 * PI * f, depth_m) for f in frequencies.tolist()])
    speeds, phases = amplitudes * 2.0 * PI * frequencies, -2.0 * PI * turns
    out = np.zeros((heights.size, 2, count))
    for i, height in enumerate(heights.tolist()):
        shares = [[_share(k, height, depth_m, sign) for k in numbers.tolist()] for sign in (1, -1)]
        sizes = speeds * np.array(shares[0]), speeds * np.array(shares[1])
        out[i] = sinusoids(frequencies, phases, sizes, step_s=TABLE_GRID_S, count=count)
    return out


def jonswap(frequency: float, peak: float) -> float:
    """Return the spectrum at a frequency [Hz] without its scale."""
    ratio = frequency / peak
    spread = 0.07 if ratio <= 1.0 else 0.09
    off = (ratio - 1.0) / spread
    enhancement = exp(log(_PEAKEDNESS) * exp(-0.5 * off * off))
    return float(exp(-5.0 * log(ratio) - 1.25 * exp(-4.0 * log(ratio))) * enhancement)


def amplitudes_of(waves: Waves, frequencies: Array) -> Array:
    """Return the amplitude of each sinusoid, (n,) [m]: their variance is height² / 16."""
    power = [jonswap(f, 1.0 / waves.period_s) for f in frequencies.tolist()]
    total = 0.0
    for one in power:
        total += one
    return waves.height_m / 4.0 * np.sqrt(2.0 * np.array(power) / total)


def wave_number(rate: float, depth_m: float) -> float:
    """Return k [rad/m] of the angular frequency [rad/s] in water of a depth: by bisection."""
    deep = rate * rate / STANDARD_GRAVITY
    # k tanh(kd) = deep lies between the deep and the sum of the deep and the shallow solution.
    low, high = deep, deep + float(np.sqrt(deep / depth_m))
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        e = exp(-2.0 * middle * depth_m)
        if middle * (1.0 - e) / (1.0 + e) < deep:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _share(k: float, height: float, depth_m: float, sign: float) -> float:
    """Return cosh(kh)/sinh(kd), or with a negative sign sinh(kh)/sinh(kd), without overflow."""
    below = exp(k * (height - depth_m))
    return float(below * (1.0 + sign * exp(-2.0 * k * height)) / (1.0 - exp(-2.0 * k * depth_m)))
