"""Acoustic positions have the stated noise, arrive late, and some never."""

from dataclasses import replace

import numpy as np
import pytest

from seamark.sim.numerics.arrays import Array
from seamark.sim.sensors.usbl import SOUND_M_S, Noise, Usbl

EXACT = Noise(period_steps=20, delay_s=0.0, range_sigma_m=0.0, angle_sigma_rad=0.0, dropout=0.0)
NOISY = replace(EXACT, range_sigma_m=0.1, angle_sigma_rad=0.0175, period_steps=1)
BOAT, STEP_S = np.array([3.0, -4.0, 2.0]), 0.05
VEHICLE = BOAT + np.array([24.0, 18.0, 16.0])  # 34 m off


def system(noise: Noise, steps: int = 2000, seed: int = 1) -> Usbl:
    return Usbl(np.random.default_rng(seed), noise, BOAT, steps=steps, step_s=STEP_S)


def positions(noise: Noise, vehicle: Array, steps: int = 2000) -> Array:
    usbl, found = system(noise, steps), []
    for step in range(steps):
        usbl.step(step, vehicle)
        if usbl.last is not None and (not found or usbl.last is not found[-1]):
            found.append(usbl.last)
    return np.array([fix.position_m for fix in found])


def test_without_noise_a_fix_is_where_the_vehicle_was() -> None:
    usbl = system(EXACT)

    usbl.step(0, VEHICLE)
    usbl.step(1, VEHICLE)

    assert usbl.last is not None
    assert np.allclose(usbl.last.position_m, VEHICLE, atol=1e-9)
    assert usbl.last.range_m == pytest.approx(34.0, abs=0.01)


def test_an_answer_that_is_not_heard_gives_no_fix_and_leaves_the_noise_of_the_others() -> None:
    whole, gap = (system(replace(NOISY, dropout=0.0)) for _ in range(2))

    whole.step(0, VEHICLE)
    gap.step(0, VEHICLE, heard=False)
    assert gap.last is None
    for step in (1, 2):
        whole.step(step, VEHICLE)
        gap.step(step, VEHICLE)

    assert whole.last is not None
    assert gap.last is not None
    assert np.array_equal(whole.last.position_m, gap.last.position_m)


def test_a_fix_is_of_the_ping_and_arrives_after_the_delay_and_the_way_of_the_sound() -> None:
    usbl = system(replace(EXACT, delay_s=1.0))
    way_s = 2.0 * float(np.linalg.norm(VEHICLE - BOAT)) / SOUND_M_S

    for step in range(40):
        usbl.step(step, VEHICLE + step)  # moves on in the meantime
        arrived = step * STEP_S >= 1.0 + way_s - 0.5 * STEP_S
        assert (usbl.last is not None) == arrived
    assert usbl.last is not None
    assert np.allclose(usbl.last.position_m, VEHICLE, atol=1e-9)
    assert usbl.last.at_step == 0


@pytest.mark.parametrize("distance", [10.0, 40.0])
def test_the_noise_across_grows_with_the_distance_as_the_system_states(distance: float) -> None:
    vehicle = BOAT + np.array([distance, 0.0, 0.0])
    usbl = system(NOISY)
    usbl.step(0, vehicle)
    usbl.step(10, vehicle)

    found = positions(NOISY, vehicle)

    assert usbl.last is not None
    along, across = found[:, 0].std(), found[:, 1].std()
    assert along == pytest.approx(0.1, rel=0.1)
    assert across == pytest.approx(0.0175 * distance, rel=0.1)
    stated = np.sqrt(0.5 * (along**2 + across**2))
    assert usbl.last.sigma_m == pytest.approx(stated, rel=0.1)
    assert np.allclose(found.mean(axis=0), vehicle, atol=0.1)


def test_the_share_of_pings_without_a_fix_is_the_set_one_and_moves_no_other_draw() -> None:
    whole, some = positions(NOISY, VEHICLE), positions(replace(NOISY, dropout=0.3), VEHICLE)

    assert len(some) / len(whole) == pytest.approx(0.7, abs=0.05)
    assert {tuple(row) for row in some.tolist()} <= {tuple(row) for row in whole.tolist()}
