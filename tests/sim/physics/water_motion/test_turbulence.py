"""Turbulence has the spectrum, the intensity and the correlation that its formulas state."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.special import gamma, kv

from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics.current import TABLE_GRID_S
from seamark.sim.physics.water_motion.places import ACROSS, PLACES, UPRIGHT
from seamark.sim.physics.water_motion.turbulence import (
    Turbulence,
    fluctuation,
    spectrum_across,
    spectrum_along,
    turbulence_of,
)

SAMPLE = Turbulence(along=0.1, across=0.075, upright=0.056, time_s=8.0)


def many(count: int, runs: int) -> np.ndarray:
    """Independent series, (runs, 3, count)."""
    return np.array([fluctuation(SAMPLE, streams(9, k, 0).turbulence, count) for k in range(runs)])


def power(series: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and the one-sided spectrum of (runs, count), with a Hann window."""
    count = series.shape[-1]
    window = np.hanning(count)
    found = np.abs(np.fft.rfft(window * series, axis=-1)) ** 2
    scale = 2.0 * TABLE_GRID_S / np.sum(window**2)
    return np.fft.rfftfreq(count, TABLE_GRID_S), scale * found.mean(axis=0)


@pytest.mark.parametrize(
    ("axis", "formula", "sigma"),
    [(0, spectrum_along, 0.1), (1, spectrum_across, 0.075), (2, spectrum_across, 0.056)],
)
def test_each_component_has_its_spectrum_with_a_tail_of_minus_five_thirds(
    axis: int, formula: object, sigma: float
) -> None:
    assert callable(formula)
    frequency, found = power(many(8192, 150)[:, axis])
    edges = 0.01 * 2.0 ** np.arange(0.0, 9.0, 0.5)  # half octaves, up to 3.6 Hz
    bands = [(frequency >= low) & (frequency < high) for low, high in pairwise(edges)]
    ours = np.array([found[band].mean() for band in bands])
    expected = [formula(frequency[band], sigma, SAMPLE.time_s).mean() for band in bands]

    assert ours == pytest.approx(expected, rel=0.2)
    middles = edges[:-1] * 2.0**0.25
    tail = middles > 0.3
    slope = np.polyfit(np.log(middles[tail]), np.log(ours[tail]), 1)[0]
    assert slope == pytest.approx(-5.0 / 3.0, abs=0.05)


def test_the_correlation_along_the_current_is_von_karmans_and_its_integral_the_time_scale() -> None:
    series = many(6000, 60)[:, 0]
    lags = np.array([1, 5, 20, 50, 100])
    found = [np.mean(series[:, lag:] * series[:, :-lag]) / np.var(series) for lag in lags]
    x = lags * TABLE_GRID_S / (1.339 * SAMPLE.time_s)

    formula = 2.0 ** (2.0 / 3.0) / gamma(1.0 / 3.0) * x ** (1.0 / 3.0) * kv(1.0 / 3.0, x)

    assert found == pytest.approx(formula, abs=0.04)
    fine = np.linspace(1e-6, 60.0, 20_001)
    whole = 2.0 ** (2.0 / 3.0) / gamma(1.0 / 3.0) * fine ** (1.0 / 3.0) * kv(1.0 / 3.0, fine)
    assert 1.339 * np.trapezoid(whole, fine) == pytest.approx(1.0, rel=0.01)


def test_the_components_have_their_standard_deviations_and_are_independent() -> None:
    found = many(4096, 40)

    assert found.std(axis=(0, 2)) == pytest.approx([0.1, 0.075, 0.056], rel=0.03)
    parts = found.transpose(1, 0, 2).reshape(3, -1)
    assert np.abs(np.corrcoef(parts) - np.eye(3)).max() < 0.05


def test_the_ria_has_the_intensities_that_were_measured_in_slow_and_in_fast_water() -> None:
    slow, fast = (turbulence_of(PLACES["ria"], speed, 2.0).along / speed for speed in (0.2, 0.9))

    assert slow == pytest.approx(0.5, abs=0.01)
    assert fast == pytest.approx(0.1, abs=0.03)


@pytest.mark.parametrize("name", PLACES)
def test_intensity_falls_with_speed_to_that_of_a_strong_current(name: str) -> None:
    place, speeds = PLACES[name], (0.05, 0.1, 0.2, 0.5, 1.0, 3.0)
    shares = [turbulence_of(place, speed, 2.0).along / speed for speed in speeds]

    assert all(a > b for a, b in pairwise(shares))
    assert shares[-1] == pytest.approx(place.intensity, rel=0.3)
    one = turbulence_of(place, 0.5, 2.0)
    assert (one.across / one.along, one.upright / one.along) == pytest.approx((ACROSS, UPRIGHT))
    assert turbulence_of(place, 0.0, 2.0)[:3] == (0.0, 0.0, 0.0)


def test_a_longer_series_begins_with_the_same_bits() -> None:
    short, long = (fluctuation(SAMPLE, streams(3, 0, 0).turbulence, n) for n in (300, 3000))

    assert short.tobytes() == np.ascontiguousarray(long[:, :300]).tobytes()
