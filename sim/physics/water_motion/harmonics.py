"""Sums of sinusoids on the grid of a table, without a Fourier transform.

Eight instants are computed side by side. Every term turns by a rotation instead of a sine of its
own, and starts anew after a while, so that no rounding piles up.
"""

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.lanes import LANES, lanes_of
from seamark.sim.numerics.libm import PI, sincos

RESTART = 1024  # points after which a rotation starts anew; a multiple of LANES


def sinusoids(
    frequencies: Array, amplitudes: Array, phases: Array, *, step_s: float, count: int
) -> Array:
    """Return sums of a cos(2 pi f t + p), (k, count).

    Parameters
    ----------
    frequencies : (n,) [Hz]
    amplitudes, phases : (n, k) [any, rad]
        Of each of k sums.
    step_s
        Between two points; the first is at t = 0.
    """
    out = np.zeros((amplitudes.shape[1], count))
    parts = np.empty((2, *amplitudes.shape))
    turning, sums = np.zeros((2, frequencies.size, LANES)), np.zeros((out.shape[0], LANES))
    rates, rotation = 2.0 * PI * frequencies, np.zeros((2, frequencies.size))
    _write_parts(amplitudes, phases, parts)
    _write_rotation(rates, LANES * step_s, rotation)
    _add(rates, parts, step_s, rotation, (turning, sums), out)
    return out


@njit(cache=True, error_model="numpy")
def _write_parts(amplitudes: Array, phases: Array, out: Array) -> None:
    """Write what a cosine and a sine without a phase are multiplied with, (2, n, k)."""
    for i in range(amplitudes.shape[0]):
        for k in range(amplitudes.shape[1]):
            s, c = sincos(phases[i, k])
            out[0, i, k], out[1, i, k] = amplitudes[i, k] * c, -amplitudes[i, k] * s


@njit(cache=True, error_model="numpy")
def _write_rotation(rates: Array, step_s: float, out: Array) -> None:
    for i in range(rates.size):
        s, c = sincos(rates[i] * step_s)
        out[0, i], out[1, i] = c, s


@njit(cache=True, error_model="numpy")
def _add(
    rates: Array,
    parts: Array,
    step_s: float,
    rotation: Array,
    buffers: tuple[Array, Array],
    out: Array,
) -> None:
    turning, sums = buffers
    turns, totals = lanes_of(turning), lanes_of(sums)
    for first in range(0, out.shape[1], LANES):
        if first % RESTART == 0:
            _start(rates, first, step_s, turning)
        for k in range(out.shape[0]):
            totals[k] = 0.0
        for i in range(rates.size):
            x, y = turns[0, i], turns[1, i]
            for k in range(out.shape[0]):
                totals[k] = totals[k] + (parts[0, i, k] * x + parts[1, i, k] * y)
            c, s = rotation[0, i], rotation[1, i]
            turns[0, i] = x * c - y * s
            turns[1, i] = x * s + y * c
        for k in range(out.shape[0]):
            for lane in range(min(LANES, out.shape[1] - first)):
                out[k, first + lane] = sums[k, lane]


@njit(cache=True, error_model="numpy")
def _start(rates: Array, first: int, step_s: float, turning: Array) -> None:
    for i in range(rates.size):
        for lane in range(LANES):
            s, c = sincos(rates[i] * ((first + lane) * step_s))
            turning[0, i, lane], turning[1, i, lane] = c, s
