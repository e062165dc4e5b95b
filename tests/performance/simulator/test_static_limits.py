"""The strongest current that thrusters can hold, where it can be computed by hand."""

import math

import pytest

from performance.simulator.static_limits import DIRECTIONS_DEG, SIDES, limit
from seamark.sim.benchmarks.currents_v2.settings import ALTERNATING, CurrentsConfiguration
from seamark.sim.vehicles import load


@pytest.mark.slow
def test_from_abeam_the_one_sway_thruster_of_a_girona_balances_the_drag() -> None:
    vehicle = load("girona500")
    linear, quadratic = vehicle.linear_drag()[1], vehicle.quadratic_drag()[1]

    for side, most in zip(SIDES.values(), vehicle.curve.limits.value, strict=True):
        expected = (math.sqrt(linear**2 + 4.0 * quadratic * most) - linear) / (2.0 * quadratic)
        assert limit(vehicle, side * math.pi / 2) == pytest.approx(expected, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ALTERNATING)
def test_the_strongest_level_of_currents_v2_is_beyond_the_limit_but_for_the_bow(name: str) -> None:
    strongest = max(CurrentsConfiguration.read({}).levels)

    assert all(
        limit(load(name), side * math.radians(degrees)) < strongest
        for degrees in DIRECTIONS_DEG[1:]
        for side in SIDES.values()
    )
