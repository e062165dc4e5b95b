"""What is wrong or unlikely about a vehicle whose file can be read, in sentences."""

import math
from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np

from seamark.sim.vehicles import capabilities
from seamark.sim.vehicles.capabilities import DIRECTIONS
from seamark.sim.vehicles.model import AXES, STANDARD_GRAVITY, Vehicle

Grade = Literal["error", "warning"]
FLAT_PLATE = 1.17  # drag coefficient of a flat plate across the flow
SLIPPERY = 0.05  # E: a torpedo has 0.1 and more on its bounding rectangle
DRAG_AT = 1.0  # [m/s]
WATER = 1000.0  # [kg/m³]
NET_SHARE = 0.1  # E: of the weight; vehicles are ballasted within 1 %
GRAVITY_ERROR = 0.02  # of standard gravity; it differs by 0.5 % on Earth
TRIM = math.radians(5.0)
ADDED_SHARE = 5.0  # E: of the displaced water
LAG_S = (0.02, 2.0)  # E: two steps of the integrator; the slowest thrusters of small vehicles
PROGRAMS_IN_C = 8  # thrusters
_SLACK = 1e-9


class Finding(NamedTuple):
    """An error: no such body exists, or the simulator cannot move it. A warning: look again."""

    grade: Grade
    text: str


def findings(vehicle: Vehicle) -> list[Finding]:
    """Return everything that is found, errors first."""
    errors = [Finding("error", text) for text in _errors(vehicle)]
    return errors + [Finding("warning", text) for text in _warnings(vehicle)]


def _errors(vehicle: Vehicle) -> Iterator[str]:
    yield from _inertia(vehicle)
    total = vehicle.mass_rigid() + vehicle.mass_added()
    if np.linalg.eigvalsh(total).min() <= 0.0:
        yield (
            "The mass matrix of body and added mass about the origin is not positive definite: "
            "check body.inertia, what it is about, and body.centre_of_gravity."
        )
    yield from _curve(vehicle)


def _inertia(vehicle: Vehicle) -> Iterator[str]:
    inertia = vehicle.inertia_about_gravity()
    if min(inertia) <= 0.0:
        yield (
            f"body.inertia about the centre of gravity is {_listed(inertia)} kg m², not positive: "
            'an inertia about = "origin" must exceed mass times squared distance.'
        )
        return
    for own in range(3):
        others = sum(inertia) - inertia[own]
        if inertia[own] > others * (1.0 + _SLACK):
            yield (
                f"body.inertia: {inertia[own]:g} kg m² about {AXES[own]} exceeds the sum of the "
                f"other two, {others:g}. No distribution of mass has that (triangle inequality)."
            )


def _curve(vehicle: Vehicle) -> Iterator[str]:
    curve = vehicle.curve
    if curve.kind != "polynomial":
        return
    for name, coefficients, most in zip(
        ("forward", "reverse"),
        (curve.forward.value, curve.reverse.value),
        curve.limits.value,
        strict=True,
    ):
        slope = np.polynomial.polynomial.polyder(coefficients)
        if np.polynomial.polynomial.polyval(np.linspace(0.0, most, 1001), slope).min() <= 0.0:
            yield (
                f"thrust.{name}: the command does not rise with the thrust everywhere from 0 to "
                f"{most:g} N, so a command has no single thrust."
            )


def _warnings(vehicle: Vehicle) -> Iterator[str]:
    yield from _balance(vehicle)
    yield from _thrusters(vehicle)
    yield from _drag(vehicle)
    yield from _places(vehicle)
    added, displaced = vehicle.mass_added(), vehicle.buoyancy.scalar / STANDARD_GRAVITY
    for axis in range(3):
        if added[axis, axis] > ADDED_SHARE * max(displaced, vehicle.mass.scalar):
            yield (
                f"body.added_mass: {added[axis, axis]:g} kg along {AXES[axis]} is more than "
                f"{ADDED_SHARE:g} times the displaced water, {displaced:.3g} kg."
            )
    low, high = LAG_S
    if not low <= vehicle.lag.scalar <= high:
        yield (
            f"thrust.lag: {vehicle.lag.scalar:g} s is unusual; thrusters need {low:g} to {high:g} "
            "s. With less, the integrator needs a shorter step."
        )


def _balance(vehicle: Vehicle) -> Iterator[str]:
    weight, buoyancy = vehicle.weight.scalar, vehicle.buoyancy.scalar
    if abs(weight / vehicle.mass.scalar / STANDARD_GRAVITY - 1.0) > GRAVITY_ERROR:
        yield (
            f"body.weight: {weight:g} N belongs to {weight / STANDARD_GRAVITY:.4g} kg, but "
            f"body.mass is {vehicle.mass.scalar:g} kg."
        )
    net = buoyancy - weight
    if abs(net) > NET_SHARE * weight:
        does = "floats up" if net > 0.0 else "sinks"
        yield (
            f"The vehicle {does} with {abs(net):.3g} N, {abs(net) / weight:.0%} of its weight: "
            "compare body.weight and body.buoyancy."
        )
    stiffness = capabilities.righting_n_m(vehicle)
    if stiffness <= 0.0:
        yield (
            "The centre of buoyancy is not above the centre of gravity (z points down, so "
            "body.centre_of_buoyancy needs the smaller z): the vehicle capsizes, or stays in any "
            "attitude."
        )
        return
    for axis, name in ((0, "pitch"), (1, "roll")):
        moment = weight * vehicle.centre_of_gravity.value[axis]
        moment -= buoyancy * vehicle.centre_of_buoyancy.value[axis]
        tilt = math.atan(abs(moment) / stiffness)
        if tilt > TRIM:
            yield (
                f"At rest the vehicle has {math.degrees(tilt):.0f}° of {name}: the centres of "
                f"gravity and buoyancy are not above each other along {AXES[axis]}."
            )


def _thrusters(vehicle: Vehicle) -> Iterator[str]:
    idle = [
        name
        for name, (axis, sign) in DIRECTIONS.items()
        if capabilities.strongest(vehicle, axis, sign) <= _SLACK
    ]
    if idle:
        yield (
            f"The thrusters cannot push {', '.join(idle)} without pushing somewhere else too: a "
            "program cannot hold its place there."
        )
    if len(vehicle.thrusters) > PROGRAMS_IN_C:
        yield f"Programs in C and C++ can read {PROGRAMS_IN_C} thrusters; the vehicle has more."


def _drag(vehicle: Vehicle) -> Iterator[str]:
    linear, quadratic = vehicle.linear_drag(), vehicle.quadratic_drag()
    for axis, coefficient in enumerate(drag_coefficients(vehicle)):
        force = linear[axis] * DRAG_AT + quadratic[axis] * DRAG_AT**2
        what = (
            f"body.drag_linear and body.drag_quadratic: {force:.3g} N along {AXES[axis]} at "
            f"{DRAG_AT:g} m/s is a coefficient of {coefficient:.2g} on the rectangle around the "
            "hull"
        )
        if coefficient > FLAT_PLATE * (1.0 + _SLACK):
            yield f"{what}, where a flat plate has {FLAT_PLATE}."
        elif 0.0 < coefficient < SLIPPERY:
            yield f"{what}, less than a torpedo's."
    free = [name for name, a, b in zip(AXES, linear, quadratic, strict=True) if a == b == 0.0]
    if free:
        yield f"Nothing brakes the motion in {', '.join(free)}: all its drag is 0."


def drag_coefficients(vehicle: Vehicle) -> tuple[float, float, float]:
    """Return the drag coefficients at `DRAG_AT` on the rectangles around the hull."""
    low, high = capabilities.bounding_box(vehicle)
    length, width, height = high - low
    areas = (width * height, length * height, length * width)
    force = vehicle.linear_drag() * DRAG_AT + vehicle.quadratic_drag() * DRAG_AT**2
    x, y, z = (float(force[i] / (0.5 * WATER * area * DRAG_AT**2)) for i, area in enumerate(areas))
    return x, y, z


def _places(vehicle: Vehicle) -> Iterator[str]:
    low, high = capabilities.bounding_box(vehicle)
    margin = 0.5 * float(np.max(high - low))
    places = {
        "body.centre_of_gravity": vehicle.centre_of_gravity,
        "body.centre_of_buoyancy": vehicle.centre_of_buoyancy,
    } | {f"Thruster {one.name}": one.position for one in vehicle.thrusters}
    for name, place in places.items():
        point = np.array(place.value)
        if (point < low - margin).any() or (point > high + margin).any():
            yield f"{name} at {_listed(place.value)} m is far outside the hull: are these metres?"


def _listed(values: tuple[float, ...]) -> str:
    return ", ".join(f"{value:g}" for value in values)
