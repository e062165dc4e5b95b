"""Caustics: surface waves focus the daylight into a moving net of light on the bottom.

The logarithm of the light is a sum of plane waves, so bright lines are narrow and dark areas wide:
skewed as measured near the surface (Gernez, Stramski & Darecki 2011). The strength is a setting and
does not follow the depth: on average the coefficient of variation is four times as large above 2 m
as at 25 m (Hieronymi & Macke 2010).
"""

from functools import lru_cache
from math import sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.seabed import hash01
from seamark.sim.numerics.libm import PI, cos, exp, log, sincos

WAVES = 8
LONGEST_M, SHORTEST_M = 1.2, 0.2  # E: ripples under a light breeze
GRAVITY_M_S2 = 9.81
BISECTIONS = 60  # of the interval that contains the amplitude
TERMS = 40  # of the Bessel function's series, for arguments up to 4

Waves = NDArray[np.float64]  # (n, 4) wave vector north, east [rad/m], frequency [rad/s], phase


@njit(cache=True, nogil=True, error_model="numpy")
def draw_waves(seed: int) -> Waves:
    """Return the waves of a seed; each obeys the dispersion of deep-water gravity waves."""
    waves = np.empty((WAVES, 4))
    ratio = exp(log(LONGEST_M / SHORTEST_M) / (WAVES - 1))
    number = 2.0 * PI / LONGEST_M
    for n in range(WAVES):
        sine, cosine = sincos(2.0 * PI * hash01(n, 0, seed))
        waves[n, 0], waves[n, 1] = number * cosine, number * sine
        waves[n, 2] = np.sqrt(GRAVITY_M_S2 * number)
        waves[n, 3] = 2.0 * PI * hash01(n, 1, seed)
        number *= ratio
    return waves


@njit(cache=True, nogil=True, error_model="numpy")
def caustic_gain(
    north: float, east: float, time_s: float, waves: Waves, amplitude: float, mean: float
) -> float:
    """Return the daylight at a position as a multiple of its mean.

    `amplitude` and `mean` are the results of `wave_amplitude`.
    """
    total = 0.0
    for n in range(waves.shape[0]):
        total += cos(waves[n, 0] * north + waves[n, 1] * east - waves[n, 2] * time_s + waves[n, 3])
    return float(exp(amplitude * total) / mean)


@lru_cache(maxsize=16)
def wave_amplitude(variation: float) -> tuple[float, float]:
    """Return each wave's amplitude for a coefficient of variation, and the mean of the light.

    Over independent phases, exp(a cos) has the mean I0(a) and the mean square I0(2 a).
    """
    low, high = 0.0, 2.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _variation(middle) < variation else (low, middle)
    return low, _bessel(low) ** WAVES


def _variation(amplitude: float) -> float:
    return sqrt((_bessel(2.0 * amplitude) / _bessel(amplitude) ** 2) ** WAVES - 1.0)


def _bessel(x: float) -> float:
    """Return I0(x), the modified Bessel function of the first kind."""
    total = term = 1.0
    for k in range(1, TERMS):
        term *= (0.5 * x / k) ** 2
        total += term
    return total
