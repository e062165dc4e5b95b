"""Caustics: as strong as stated, moving, and no light won or lost."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.camera.caustics import (
    LONGEST_M,
    SHORTEST_M,
    WAVES,
    caustic_gain,
    draw_waves,
    wave_amplitude,
)
from seamark.sim.camera.effects import Effects

START = start_pose(VISIBILITY, Target(), 1.27)


@given(variation=st.floats(0.05, 1.5))
@settings(max_examples=20, deadline=None)
def test_amplitude_gives_the_stated_variation_by_numpys_bessel_function(variation: float) -> None:
    amplitude, mean = wave_amplitude(variation)

    assert mean == pytest.approx(np.i0(amplitude) ** WAVES, rel=1e-12)
    square = np.i0(2 * amplitude) ** WAVES
    assert np.sqrt(square / mean**2 - 1.0) == pytest.approx(variation, rel=1e-9)


@pytest.mark.parametrize("variation", [0.1, 0.4])
@pytest.mark.parametrize("seed", [1, 5])
def test_light_over_a_wide_field_has_the_mean_one_and_the_stated_variation(variation, seed) -> None:
    waves = draw_waves(seed)
    amplitude, mean = wave_amplitude(variation)
    places = np.random.default_rng(2).uniform(-300.0, 300.0, (40_000, 3))

    light = np.array([caustic_gain(x, y, abs(t), waves, amplitude, mean) for x, y, t in places])

    assert light.mean() == pytest.approx(1.0, abs=4 * variation / 200)
    assert light.std() == pytest.approx(variation, rel=0.05)
    assert np.mean((light - 1.0) ** 3) > 0.0  # narrow bright lines, wide dark fields


def test_waves_are_as_long_as_stated_and_run_as_gravity_waves_do() -> None:
    north, east, frequency, _ = draw_waves(3).T
    number = np.hypot(north, east)

    assert 2 * np.pi / number[[0, -1]] == pytest.approx([LONGEST_M, SHORTEST_M])
    assert frequency**2 == pytest.approx(9.81 * number)


def test_the_net_of_light_moves_and_the_bottom_stays_as_bright() -> None:
    def bright(caustics: float, frame: int) -> np.ndarray:
        effects = Effects(caustics=caustics, frame_s=0.05)
        camera = Camera(VISIBILITY, Water.grey(0.0), Target(), noise_seed=4, effects=effects)
        return camera.grey(START, frame)[:60].astype(float)  # beside the target

    calm = bright(0.0, 0)
    times = range(0, 1200, 40)
    nets = [bright(0.3, frame) / calm for frame in times]

    assert np.mean(nets) == pytest.approx(1.0, abs=0.05)
    assert np.abs(nets[0] - nets[1]).mean() > 0.1
