"""Sums of sinusoids on the grid of a table, without a Fourier transform."""

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import PI, sincos

RESTART = 1024  # points after which a rotation starts again, so that no rounding piles up


def sinusoids(
    frequencies: Array,
    phases: Array,
    amplitudes: tuple[Array, Array],
    *,
    step_s: float,
    count: int,
) -> Array:
    """Return the sums of a cos(2 pi f t + p) and of b sin(2 pi f t + p), (2, count).

    Parameters
    ----------
    frequencies, phases : (n,) [Hz, rad]
    amplitudes : a and b, (n,) each
    step_s
        Between two points; the first is at t = 0.
    """
    out = np.zeros((2, count))
    work = np.zeros((4, frequencies.size))
    _add(2.0 * PI * frequencies, phases, np.array(amplitudes), step_s, work, out)
    return out


@njit(cache=True, error_model="numpy")
def _add(
    rates: Array, phases: Array, amplitudes: Array, step_s: float, work: Array, out: Array
) -> None:
    for at in range(out.shape[1]):
        if at % RESTART == 0:
            _start(rates, phases, at * step_s, step_s, work)
        c, s = 0.0, 0.0
        for i in range(rates.size):
            x, y = work[0, i], work[1, i]
            c += amplitudes[0, i] * x
            s += amplitudes[1, i] * y
            work[0, i] = x * work[2, i] - y * work[3, i]
            work[1, i] = x * work[3, i] + y * work[2, i]
        out[0, at], out[1, at] = c, s


@njit(cache=True, error_model="numpy")
def _start(rates: Array, phases: Array, t: float, step_s: float, work: Array) -> None:
    for i in range(rates.size):
        s, c = sincos(rates[i] * t + phases[i])
        turn_s, turn_c = sincos(rates[i] * step_s)
        work[0, i], work[1, i], work[2, i], work[3, i] = c, s, turn_c, turn_s
