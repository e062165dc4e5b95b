"""Compare the turbulence of places with its formulas: `./run performance turbulence`."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import gamma, kv

from performance.plots import COLOURS, figure
from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics.current import TABLE_GRID_S
from seamark.sim.physics.water_motion.places import PLACES
from seamark.sim.physics.water_motion.turbulence import (
    fluctuation,
    spectrum_across,
    spectrum_along,
    turbulence_of,
)

FIGURE = Path("docs/figures/turbulence.png")
RUNS, COUNT = 150, 8192
SPEED, HEIGHT_M = 0.4, 2.27  # [m/s, m] a middle level, and the height of the start
PLACE = "ria"
LAGS_S = np.array([0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 24.0])
Array = NDArray[np.float64]


def main(_arguments: Sequence[str]) -> int:
    """Print the comparison and draw it."""
    turbulence = turbulence_of(PLACES[PLACE], SPEED, HEIGHT_M)
    series = np.array(
        [fluctuation(turbulence, streams(1, k, 0).turbulence, COUNT) for k in range(RUNS)]
    )
    sigmas, scale = turbulence[:3], turbulence.time_s
    print(f"{PLACE}, {SPEED} m/s at {HEIGHT_M} m: time scale {scale:.1f} s, {RUNS} series")
    names, lines = ("along", "across", "upright"), []
    for axis, name in enumerate(names):
        formula = spectrum_across if axis else spectrum_along
        middles, ours = _banded(series[:, axis])
        expected = formula(middles, sigmas[axis], scale)
        tail = middles > 1.0
        slope = np.polyfit(np.log(middles[tail]), np.log(ours[tail]), 1)[0]
        error = float(np.abs(ours / expected - 1.0).max())
        print(
            f"{name:8} deviation {series[:, axis].std():.4f}, formula {sigmas[axis]:.4f} m/s; "
            f"slope {slope:.3f}, formula -1.667; largest error of a band {error:.0%}"
        )
        lines.append((middles, ours, expected, name))
    found, expected = _correlation(series[:, 0]), karman(LAGS_S / scale)
    print(f"correlation: largest error {np.abs(found - expected).max():.3f}")
    for name, place in PLACES.items():
        told = (f"{turbulence_of(place, u, HEIGHT_M).along / u:.0%}" for u in (0.1, 0.2, 0.5, 1.0))
        print(f"{name:8} intensity at 0.1, 0.2, 0.5, 1 m/s: {', '.join(told)}")
    _draw(lines, found, expected)
    return 0


def karman(ratio: Array) -> Array:
    """Return von Karman's correlation along the current at lags over the time scale, (n,)."""
    x = ratio / 1.339
    out: Array = 2.0 ** (2.0 / 3.0) / gamma(1.0 / 3.0) * x ** (1.0 / 3.0) * kv(1.0 / 3.0, x)
    return out


def _banded(series: Array) -> tuple[Array, Array]:
    """Return middles of half octaves [Hz] and the spectrum of (runs, count) there."""
    window = np.hanning(COUNT)
    power = np.abs(np.fft.rfft(window * series, axis=-1)) ** 2
    spectrum = 2.0 * TABLE_GRID_S / np.sum(window**2) * power.mean(axis=0)
    frequency = np.fft.rfftfreq(COUNT, TABLE_GRID_S)
    edges = 0.005 * 2.0 ** np.arange(0.0, 10.0, 0.5)
    bands = [spectrum[(frequency >= a) & (frequency < b)].mean() for a, b in pairwise(edges)]
    return edges[:-1] * 2.0**0.25, np.array(bands)


def _correlation(series: Array) -> Array:
    steps = np.round(LAGS_S / TABLE_GRID_S).astype(int).tolist()
    variance = np.var(series)
    return np.array([np.mean(series[:, n:] * series[:, :-n]) / variance for n in steps])


def _draw(lines: Sequence[tuple[Array, Array, Array, str]], found: Array, expected: Array) -> None:
    with figure(FIGURE, rows=2, height=7.0, share_x=False) as (above, below):
        for (middles, ours, formula, name), colour in zip(lines, COLOURS, strict=False):
            above.loglog(middles, ours, "o", color=colour, markersize=4, label=name)
            above.loglog(middles, formula, color=colour)
        slope = np.array([0.5, 4.0])
        above.loglog(slope, 0.02 * slope ** (-5.0 / 3.0), "k--", label="f^(-5/3)")
        above.set(xlabel="frequency [Hz]", ylabel="S [m²/s² per Hz]")
        above.legend()
        below.plot(LAGS_S, found, "o", color=COLOURS[0], label="along")
        below.plot(LAGS_S, expected, color=COLOURS[0], label="von Kármán")
        below.set(xlabel="lag [s]", ylabel="correlation")
        below.legend()
