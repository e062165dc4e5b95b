"""The shear of the current: a profile with a law, and what a hull feels that moves through it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics.current import MIN_HEIGHT_M, Current, Pattern, Shear, profile
from seamark.sim.physics.plant import Plant
from seamark.sim.recording.telemetry import INDEX
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.vehicles import Quantity, Vehicle, load
from tests.sim.conftest import RunOf

STEADY = Pattern(azimuth_swing_rad=0.0, speed_swing=0.0)
BOTTOM = 5.0
SHEAR = Shear(exponent=0.5, bottom_m=BOTTOM, height_m=2.0)


def quantity(*value: float) -> Quantity:
    return Quantity(meaning="test", value=value, unit="", tag="E", source="test")


def drifting(added: float) -> Vehicle:
    """A neutral vehicle without drag whose added mass is the same along all axes."""
    vehicle = load("girona500-uwsim")
    none, origin = (quantity(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),), quantity(0.0, 0.0, 0.0)
    return replace(
        vehicle,
        added_mass=(quantity(added, added, added), quantity(0.0, 0.0, 0.0)),
        drag_linear=none,
        drag_quadratic=none,
        buoyancy=vehicle.weight,
        centre_of_gravity=origin,
        centre_of_buoyancy=origin,
    )


def sunk(vehicle: Vehicle) -> Plant:
    """A plant that went 2 m down through the shear, at 0.5 m/s and at rest in the water before."""
    plant = Plant(vehicle, Current(0.4, pattern=STEADY, shear=SHEAR))
    plant.reset(np.array([0.0, 0.0, 2.0, 0.0, 0.0, 0.0]))
    plant.state[7:10] = *plant.current_world()[:2], 0.5
    plant.advance(0, np.zeros(5), 400)
    return plant


@given(exponent=st.floats(0.0, 1.0), height=st.floats(0.2, 5.0))
def test_at_its_own_height_the_current_has_the_level(exponent: float, height: float) -> None:
    shear = Shear(exponent=exponent, bottom_m=BOTTOM, height_m=height)
    current = Current(0.4, pattern=STEADY, shear=shear)

    assert current.velocity(3.0, BOTTOM - height)[0] == pytest.approx(-0.4, rel=1e-14)


@given(depth=st.floats(0.0, 4.9, exclude_max=True), exponent=st.floats(0.05, 1.0))
def test_the_profile_is_the_power_law_and_slower_the_deeper(depth: float, exponent: float) -> None:
    shear = Shear(exponent=exponent, bottom_m=BOTTOM, height_m=2.0)
    law = (shear.exponent, shear.bottom_m, shear.height_m)

    share, slope = profile(depth, *law)
    step = 1e-6
    around = [profile(depth + side, *law)[0] for side in (-step, step)]

    assert share == pytest.approx(((BOTTOM - depth) / 2.0) ** exponent, rel=1e-14)
    assert slope < 0.0
    if depth < BOTTOM - MIN_HEIGHT_M - step:
        assert slope == pytest.approx((around[1] - around[0]) / (2.0 * step), rel=1e-3)


def test_near_and_below_the_bottom_the_profile_is_constant() -> None:
    law = (SHEAR.exponent, SHEAR.bottom_m, SHEAR.height_m)

    shares = [profile(depth, *law) for depth in (BOTTOM - 0.05, BOTTOM, BOTTOM + 3.0)]

    assert shares == [shares[0]] * 3
    assert shares[0][0] == pytest.approx((MIN_HEIGHT_M / 2.0) ** 0.5)


def test_an_exponent_of_zero_gives_the_bytes_of_no_shear() -> None:
    states = []
    for shear in (None, Shear(exponent=0.0, bottom_m=BOTTOM, height_m=2.0)):
        current = Current(0.3, shear=shear, rng=streams(1, 0, 0).gust)
        plant = Plant(load("girona500"), current)
        plant.reset(np.array([0.0, 0.0, 2.0, 0.1, 0.0, 0.0]))
        plant.advance(0, np.full(5, 0.3), 500)
        states.append(plant.state.tobytes())

    assert states[0] == states[1]


def test_a_hull_with_drag_ends_at_the_speed_of_the_water_at_its_depth() -> None:
    vehicle = load("girona500")
    for depth in (2.0, 4.0):
        plant = Plant(
            replace(vehicle, buoyancy=vehicle.weight),
            Current(0.4, pattern=STEADY, shear=SHEAR),
        )
        plant.reset(np.array([0.0, 0.0, depth, 0.0, 0.0, 0.0]))
        plant.advance(0, np.zeros(5), 60_000)

        expected = -0.4 * ((BOTTOM - plant.pose()[2]) / 2.0) ** 0.5
        assert plant.velocity()[0] == pytest.approx(expected, rel=0.02)
        assert plant.current_world()[0] == pytest.approx(expected, rel=1e-12)


def test_a_hull_without_added_mass_and_drag_keeps_its_way_through_the_shear() -> None:
    plant = sunk(drifting(0.0))

    assert plant.pose()[2] == pytest.approx(4.0)
    assert plant.velocity()[0] == pytest.approx(-0.4 * 1.5**0.5, rel=1e-12)


def test_added_mass_takes_the_hull_along_by_its_share() -> None:
    plant = sunk(drifting(49.0))

    before, now = -0.4 * 1.5**0.5, -0.4 * 0.5**0.5
    expected = before + (now - before) * 49.0 / (98.0 + 49.0)
    assert plant.velocity()[0] == pytest.approx(expected, rel=1e-9)


def test_a_run_in_a_sheared_current_records_the_water_at_the_vehicle(run_short: RunOf) -> None:
    _result, rows = run_short({"current_shear": 1.0, "current_swing_rad": 0.0, "tracker": "truth"})

    at_start = rows[[0, 120], INDEX["current_x"]]
    assert at_start[0] / at_start[1] == pytest.approx(0.1 / 0.3, rel=0.3)
    height = 5.0 - rows[:, INDEX["z"]]
    share = height / height[0]
    _result, even = run_short({"current_swing_rad": 0.0, "tracker": "truth"})
    expected = even[:, INDEX["current_x"]] * share
    assert rows[:, INDEX["current_x"]] == pytest.approx(expected, rel=1e-12)
    assert np.ptp(share) > 1e-4


def test_shear_is_refused_where_the_current_is_a_force(currents: Benchmark) -> None:
    with pytest.raises(ConfigurationInvalid, match="the water itself is at rest"):
        currents.read({"current_law": "force", "current_shear": 0.1})
    with pytest.raises(ValueError, match="shear needs the relative law"):
        Current(0.1, pattern=Pattern(law="force"), shear=SHEAR)


@pytest.mark.parametrize("wrong", [{"exponent": -0.1}, {"exponent": 1.5}, {"height_m": 0.05}])
def test_profiles_without_a_meaning_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must be"):
        replace(SHEAR, **wrong)
