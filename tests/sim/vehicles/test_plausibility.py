"""Each finding about a vehicle is made where it is true, and nowhere else."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import Vehicle, load
from seamark.sim.vehicles.plausibility import findings

Change = Callable[[Vehicle], Vehicle]


def valued(name: str, *value: float) -> Change:
    """Return the change that gives a quantity another value."""
    return lambda vehicle: replace(
        vehicle, **{name: replace(getattr(vehicle, name), value=value)}
    )  # fmt: skip


def grouped(name: str, *values: tuple[float, ...]) -> Change:
    """Return the change that gives the groups of a quantity other values."""

    def change(vehicle: Vehicle) -> Vehicle:
        groups = zip(getattr(vehicle, name), values, strict=True)
        return replace(
            vehicle, **{name: tuple(replace(group, value=value) for group, value in groups)}
        )

    return change


def without_sway(vehicle: Vehicle) -> Vehicle:
    return replace(vehicle, thrusters=vehicle.thrusters[4:])


def in_millimetres(vehicle: Vehicle) -> Vehicle:
    first = vehicle.thrusters[0]
    far = replace(first, position=replace(first.position, value=(140.0, 92.0, 0.0)))
    return replace(vehicle, thrusters=(far, *vehicle.thrusters[1:]))


def falling_curve(vehicle: Vehicle) -> Vehicle:
    forward = replace(vehicle.curve.forward, value=(0.0, 0.1, -0.01))
    reverse = replace(vehicle.curve.reverse, value=(0.0, 0.02))
    return replace(
        vehicle, curve=replace(vehicle.curve, kind="polynomial", forward=forward, reverse=reverse)
    )


def with_more_thrusters(vehicle: Vehicle) -> Vehicle:
    more = replace(vehicle.thrusters[0], name="more")
    return replace(vehicle, thrusters=(*vehicle.thrusters, more))


def about_the_origin(vehicle: Vehicle) -> Vehicle:
    low = replace(vehicle.centre_of_gravity, value=(0.0, 0.0, 0.5))
    return replace(vehicle, inertia_point="origin", centre_of_gravity=low)


CHANGES: dict[str, tuple[Change, str, str]] = {
    "triangle": (valued("inertia", 1.0, 0.2, 0.3), "error", "exceeds the sum of the other two"),
    "about the origin": (about_the_origin, "error", "about the centre of gravity is"),
    "falling curve": (falling_curve, "error", "does not rise with the thrust"),
    "weight": (valued("weight", 13.5), "warning", "belongs to 1.377 kg, but body.mass is 13.5"),
    "net buoyancy": (valued("buoyancy", 200.0), "warning", "floats up with 67.4 N, 51% of its"),
    "capsizing": (valued("centre_of_buoyancy", 0.0, 0.0, 0.02), "warning", "the vehicle capsizes"),
    "trim": (valued("centre_of_buoyancy", 0.005, 0.0, -0.01), "warning", "27° of pitch"),
    "heel": (valued("centre_of_buoyancy", 0.0, 0.01, -0.01), "warning", "45° of roll"),
    "sway": (without_sway, "warning", "ahead, astern, to starboard, to port, turning to starboard"),
    "drag": (grouped("drag_quadratic", (400.0, 100.0, 100.0), (1.0, 1.0, 1.0)), "warning",
             "N along x at 1 m/s is a coefficient of 5.5"),
    "slippery": (grouped("drag_linear", (0.0, 4.0, 4.0), (1.0, 1.0, 1.0)), "warning",
                 "less than a torpedo's"),
    "no drag": (grouped("drag_quadratic", (3.0, 60.0, 60.0), (1.0, 1.0, 0.0)), "warning",
                "Nothing brakes the motion in yaw"),
    "added mass": (grouped("added_mass", (5.0, 5.0, 500.0), (1.0, 1.0, 1.0)), "warning",
                   "500 kg along z is more than 5 times"),
    "short lag": (valued("lag", 0.001), "warning", "thrust.lag: 0.001 s is unusual"),
    "long lag": (valued("lag", 20.0), "warning", "thrust.lag: 20 s is unusual"),
    "millimetres": (in_millimetres, "warning", "are these metres?"),
    "thrusters": (with_more_thrusters, "warning", "can read 8 thrusters"),
}  # fmt: skip


def plausible() -> Vehicle:
    """A vehicle about which nothing is found."""
    slow = grouped("drag_linear", (4.0, 4.0, 4.0), (0.1, 0.1, 0.0))
    drag = grouped("drag_quadratic", (3.0, 60.0, 60.0), (1.0, 1.0, 1.0))
    return slow(drag(load("bluerov2-heavy")))


def test_nothing_is_found_where_nothing_is_wrong() -> None:
    assert findings(plausible()) == []


@pytest.mark.parametrize("change", CHANGES)
def test_what_is_wrong_is_said(change: str) -> None:
    apply, grade, said = CHANGES[change]

    found = findings(apply(plausible()))

    assert [one.grade for one in found if said in one.text] == [grade]


def test_a_body_whose_mass_matrix_is_not_positive_is_an_error() -> None:
    turned = valued("inertia", 1e-3, 1e-3, 1e-3)(plausible())
    apart = replace(
        grouped("added_mass", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))(turned), inertia_point="origin"
    )
    low = replace(apart, centre_of_gravity=replace(apart.centre_of_gravity, value=(0, 0, 0.2)))

    assert any("not positive definite" in one.text for one in findings(low))


@pytest.mark.parametrize("name", VEHICLES)
def test_no_vehicle_of_ours_has_an_error(name: str) -> None:
    assert [one for one in findings(load(name)) if one.grade == "error"] == []


def test_the_first_bluerov2_heavy_has_more_drag_than_a_plate_ahead_and_the_second_less() -> None:
    ahead = "along x at 1 m/s"
    told = {
        name: [one.text for one in findings(load(name)) if ahead in one.text]
        for name in ("bluerov2-heavy", "bluerov2-heavy-v2")
    }

    assert len(told["bluerov2-heavy"]) == 1
    assert told["bluerov2-heavy-v2"] == []
