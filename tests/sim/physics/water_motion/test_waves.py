"""Surface waves move the water below them as linear theory says."""

import math

import numpy as np
import pytest

from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics.current import TABLE_GRID_S
from seamark.sim.physics.water_motion.waves import (
    Waves,
    amplitudes_of,
    jonswap,
    orbital_velocity,
    wave_number,
)

SEA = Waves(height_m=0.8, period_s=6.0)
DEPTH = 5.0


@pytest.mark.parametrize("period_s", [2.0, 6.0, 20.0])
@pytest.mark.parametrize("depth_m", [1.0, 5.0, 200.0])
def test_the_wave_number_solves_the_dispersion_relation(period_s: float, depth_m: float) -> None:
    rate = 2.0 * math.pi / period_s

    k = wave_number(rate, depth_m)

    assert 9.80665 * k * math.tanh(k * depth_m) == pytest.approx(rate**2, rel=1e-12)


def test_jonswap_peaks_at_its_peak_and_its_waves_have_the_significant_height() -> None:
    frequencies = np.linspace(0.08, 0.6, 400)
    shape = [jonswap(f, 1.0 / SEA.period_s) for f in frequencies.tolist()]

    assert frequencies[int(np.argmax(shape))] == pytest.approx(1.0 / 6.0, abs=0.002)
    assert 4.0 * math.sqrt(np.sum(amplitudes_of(SEA, frequencies) ** 2) / 2.0) == pytest.approx(0.8)


def test_orbits_flatten_towards_the_bottom_and_have_the_formulas_size() -> None:
    heights = np.array([0.0, 1.0, 2.5, 4.5])
    runs = [orbital_velocity(SEA, heights, DEPTH, streams(1, k, 0).waves, 6000) for k in range(10)]
    found = np.array(runs).std(axis=(0, 3))  # (heights, 2)
    frequencies = np.linspace(0.5, 4.0, 2000) / SEA.period_s
    sizes = amplitudes_of(SEA, frequencies) * 2.0 * np.pi * frequencies
    numbers = np.array([wave_number(2.0 * np.pi * f, DEPTH) for f in frequencies.tolist()])

    for height, (along, down) in zip(heights.tolist(), found.tolist(), strict=True):
        over = np.sinh(numbers * DEPTH)
        u, w = sizes * np.cosh(numbers * height) / over, sizes * np.sinh(numbers * height) / over
        assert along == pytest.approx(math.sqrt(np.sum(u**2) / 2.0), rel=0.05)
        assert down == pytest.approx(math.sqrt(np.sum(w**2) / 2.0), rel=0.05, abs=1e-12)
    assert np.all(np.diff(found, axis=0) > 0.0)


def test_the_water_accelerates_up_below_a_trough_and_conserves_volume_in_long_waves() -> None:
    # In shallow water the surface's speed is that of the water below it: w = dh/dt, u = h c / d.
    long = Waves(height_m=0.2, period_s=20.0)
    ((u, w),) = orbital_velocity(long, np.array([4.999]), DEPTH, streams(1, 0, 0).waves, 3000)
    speed = math.sqrt(9.80665 * DEPTH)

    rise = -w[1:-1]
    surface = np.gradient(u, TABLE_GRID_S)[1:-1] * DEPTH / speed

    assert np.corrcoef(rise, surface)[0, 1] > 0.95
