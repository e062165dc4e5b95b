"""Vehicles whose real parameters differ from the nominal ones, within what is known of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from seamark.sim.vehicles import Quantity, Vehicle

NOMINAL_AXES = (1.0,) * 6


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleFactors:
    """Real parameters over nominal ones; axes are surge, sway, heave, roll, pitch, yaw.

    Weight and buoyancy stay nominal: a vehicle is ballasted before a mission.
    """

    mass: float = 1.0  # of the rigid body, with its inertia
    added_mass: tuple[float, ...] = NOMINAL_AXES
    drag: tuple[float, ...] = NOMINAL_AXES  # linear and quadratic


def varied(vehicle: Vehicle, factors: VehicleFactors) -> Vehicle:
    """Return the vehicle with its parameters multiplied by the factors."""
    return replace(
        vehicle,
        mass=_scaled(vehicle.mass, [factors.mass]),
        inertia=_scaled(vehicle.inertia, [factors.mass] * 3),
        added_mass=_scaled_groups(vehicle.added_mass, factors.added_mass),
        drag_linear=_scaled_groups(vehicle.drag_linear, factors.drag),
        drag_quadratic=_scaled_groups(vehicle.drag_quadratic, factors.drag),
    )


def _scaled(quantity: Quantity, factors: Sequence[float]) -> Quantity:
    pairs = zip(quantity.value, factors, strict=True)
    return replace(quantity, value=tuple(value * factor for value, factor in pairs))


def _scaled_groups(
    groups: tuple[Quantity, ...], factors: tuple[float, ...]
) -> tuple[Quantity, ...]:
    """Return groups that together have six numbers, one for each factor."""
    scaled, first = [], 0
    for group in groups:
        end = first + len(group.value)
        scaled.append(_scaled(group, factors[first:end]))
        first = end
    return tuple(scaled)
