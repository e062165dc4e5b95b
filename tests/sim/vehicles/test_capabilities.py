"""What a vehicle can do: against a linear programme, closed forms, and the plant itself."""

import math
from dataclasses import replace

import numpy as np
import pytest
import scipy  # its parts are loaded when they are used
from hypothesis import given, settings
from hypothesis import strategies as some

from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.current import Current
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.thrusters import pack_curve, thrust_from_command
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import Quantity, Thruster, Vehicle, capabilities, load
from seamark.sim.vehicles.capabilities import BALANCED, DIRECTIONS, HEAVE, SURGE, SWAY, YAW


def by_linear_programme(vehicle: Vehicle, axis: int, sign: float) -> float:
    """The greatest force along an axis, the other balanced ones at rest."""
    rows = vehicle.allocation()[list(BALANCED)]
    wanted, carried = np.zeros(6), np.zeros(6)
    wanted[axis] = sign
    carried[HEAVE] = vehicle.buoyancy.scalar - vehicle.weight.scalar
    forward, reverse = capabilities.full_thrust(vehicle.curve)
    thrusters = rows.shape[1]
    found = scipy.optimize.linprog(
        np.append(np.zeros(thrusters), -1.0),
        A_eq=np.column_stack([rows, -wanted[list(BALANCED)]]),
        b_eq=carried[list(BALANCED)],
        bounds=[(-reverse, forward)] * thrusters + [(0.0, None)],
    )
    return -float(found.fun) if found.success else 0.0


@pytest.mark.parametrize("name", VEHICLES)
@pytest.mark.parametrize("direction", DIRECTIONS)
def test_the_strongest_force_is_that_of_a_linear_programme(name: str, direction: str) -> None:
    vehicle, (axis, sign) = load(name), DIRECTIONS[direction]

    force = capabilities.strongest(vehicle, axis, sign)

    assert force == pytest.approx(by_linear_programme(vehicle, axis, sign), abs=1e-6)


def thruster(number: int, values: list[float]) -> Thruster:
    position, direction = np.array(values[:3]), np.array(values[3:])
    x, y, z = direction / np.linalg.norm(direction)
    place = Quantity(meaning="", value=tuple(position), unit="m", tag="E", source="")
    return Thruster(name=str(number), position=place, direction=(x, y, z))


PLACED = some.lists(
    some.lists(some.floats(0.1, 1.0), min_size=6, max_size=6), min_size=4, max_size=9
)


@pytest.mark.slow
@settings(deadline=None, max_examples=25)
@given(placed=PLACED, signs=some.integers(0, 2**30))
def test_any_thrusters_are_as_strong_as_the_linear_programme_says(
    placed: list[list[float]], signs: int
) -> None:
    turned = [
        [value if signs >> (6 * at + digit) % 30 & 1 else -value for digit, value in enumerate(one)]
        for at, one in enumerate(placed)
    ]
    thrusters = tuple(thruster(number, one) for number, one in enumerate(turned))
    base = load("bluerov2-heavy")
    vehicle = replace(base, thrusters=thrusters, buoyancy=base.weight)

    for axis, sign in DIRECTIONS.values():
        force = capabilities.strongest(vehicle, axis, sign)
        assert force == pytest.approx(by_linear_programme(vehicle, axis, sign), abs=1e-4, rel=1e-4)


@pytest.mark.parametrize("name", VEHICLES)
def test_full_thrust_is_that_of_the_full_command(name: str) -> None:
    curve = load(name).curve
    packed = pack_curve(curve)

    forward, reverse = capabilities.full_thrust(curve)

    assert forward == pytest.approx(thrust_from_command(1.0, packed), rel=1e-6)
    assert -reverse == pytest.approx(thrust_from_command(-1.0, packed), rel=1e-6)


@pytest.mark.parametrize("name", VEHICLES)
@pytest.mark.parametrize("axis", [SURGE, SWAY, HEAVE, YAW])
def test_at_the_greatest_speed_drag_equals_the_force(name: str, axis: int) -> None:
    vehicle = load(name)

    speed = capabilities.speed_at(vehicle, axis, 50.0)

    drag = vehicle.linear_drag()[axis] * speed + vehicle.quadratic_drag()[axis] * speed**2
    assert drag == pytest.approx(50.0)


def balanced(vehicle: Vehicle) -> Vehicle:
    """The vehicle, neutral and with both centres where the thrusters push."""
    nowhere = replace(vehicle.centre_of_gravity, value=(0.0, 0.0, 0.0))
    return replace(
        vehicle, buoyancy=vehicle.weight, centre_of_gravity=nowhere, centre_of_buoyancy=nowhere
    )


def full_ahead(vehicle: Vehicle) -> Array:
    return np.asarray(np.sign(np.round(vehicle.allocation()[SURGE], 9)))


@pytest.mark.parametrize("name", ["girona500", "bluerov2-heavy-v2"])
def test_the_plant_is_as_quick_and_as_fast_as_its_response_says(name: str) -> None:
    vehicle = balanced(load(name))
    found = capabilities.response(vehicle, "ahead")
    plant = Plant(vehicle, Current(0.0), step_s=0.001)

    plant.advance(0, full_ahead(vehicle), round(found.time_s / plant.step_s))

    speed = float(plant.velocity()[0])
    assert speed == pytest.approx(capabilities.SHARE * found.speed, rel=0.01)


def test_a_vehicle_that_cannot_carry_its_weight_cannot_hold_anything() -> None:
    vehicle = load("bluerov2-heavy")
    heavy = replace(vehicle, weight=replace(vehicle.weight, value=(400.0,)))

    assert capabilities.strongest(heavy, SURGE, 1.0) == 0.0
    assert by_linear_programme(heavy, SURGE, 1.0) == 0.0


def test_without_a_thruster_for_sway_there_is_no_force_to_starboard() -> None:
    girona = load("girona500")
    rest = replace(girona, thrusters=girona.thrusters[:-1])

    assert capabilities.strongest(rest, SWAY, 1.0) == 0.0
    assert capabilities.strongest(rest, SURGE, 1.0) > 200.0


def test_the_righting_moment_swings_a_pendulum() -> None:
    vehicle = load("girona500")

    stiffness = capabilities.righting_n_m(vehicle)

    assert stiffness == pytest.approx(1403.0 * 0.054 + 1413.0 * 0.166)
    assert capabilities.period_s(vehicle, capabilities.PITCH) == pytest.approx(
        2.0 * math.pi * math.sqrt(110.0 / stiffness), rel=1e-6
    )


def test_the_measured_forces_of_the_bluerov2_heavy_are_met() -> None:
    vehicle = load("bluerov2-heavy-v2")
    drag = vehicle.linear_drag() + vehicle.quadratic_drag()

    ahead = capabilities.response(vehicle, "ahead")

    assert ahead.force == pytest.approx(9.0 * 9.80665, rel=0.01)  # the maker's bollard pull
    assert 45.0 < drag[SURGE] < 45.0 * 0.571 / 0.338  # a current tank, and the Heavy's width
    assert 1.0 < ahead.speed < 1.25  # the maker states 1 m/s


@pytest.mark.parametrize("name", VEHICLES)
def test_every_spread_encloses_its_value(name: str) -> None:
    for place, quantity in load(name).quantities():
        low, high = quantity.spread or (quantity.value, quantity.value)
        assert all(a <= b <= c for a, b, c in zip(low, quantity.value, high, strict=True)), place
