"""The parameters that a log can say something about, and a vehicle that has them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.linear_algebra import inverse
from seamark.sim.physics.dynamics import Body, body_parameters
from seamark.sim.vehicles import AXES, Quantity, Vehicle

KINDS = ("added_mass", "drag_linear", "drag_quadratic")
WORDS = {
    "added_mass": "added mass",
    "drag_linear": "linear drag",
    "drag_quadratic": "quadratic drag",
}
MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
COUNT = len(KINDS) * len(AXES)  # parameters, in the order of KINDS, then of AXES
_UNITS = {
    "added_mass": ("kg", "kg m²"),
    "drag_linear": ("N s/m", "N m s"),
    "drag_quadratic": ("N s²/m²", "N m s²"),
}
_USUAL_SPEED = 0.5  # [m/s, rad/s] at which a drag coefficient is compared with the whole drag


def kind_of(index: int) -> str:
    """Return the key of a parameter in a vehicle's file."""
    return KINDS[index // len(AXES)]


def axis_of(index: int) -> int:
    """Return the axis of a parameter, 0 to 5."""
    return index % len(AXES)


def name_of(index: int) -> str:
    """Return what people call a parameter, such as "surge, linear drag"."""
    return f"{MOTIONS[axis_of(index)]}, {WORDS[kind_of(index)]}"


def unit_of(index: int) -> str:
    """Return the unit of a parameter."""
    return _UNITS[kind_of(index)][axis_of(index) // 3]


def parameters_of(vehicle: Vehicle) -> Array:
    """Return the parameters of a vehicle, (18,), positive as in its file."""
    added = np.diag(vehicle.mass_added())
    return np.concatenate([added, vehicle.linear_drag(), vehicle.quadratic_drag()])


def scales_of(vehicle: Vehicle) -> Array:
    """Return by how much each parameter may well differ, (18,).

    It is the whole inertia of the axis, or its whole drag coefficient at 0.5 m/s or rad/s.
    """
    inertia = np.diag(vehicle.mass_rigid() + vehicle.mass_added())
    linear, quadratic = vehicle.linear_drag(), vehicle.quadratic_drag()
    drag = linear + quadratic * _USUAL_SPEED
    drag = np.where(drag > 0.0, drag, inertia)
    return np.concatenate([inertia, drag, drag / _USUAL_SPEED])


def body_with(vehicle: Vehicle, values: Array) -> Body | None:
    """Return the compiled code's body with other parameters; None if its mass is not positive."""
    added, linear, quadratic = values.reshape(len(KINDS), len(AXES))
    mass = vehicle.mass_rigid() + np.diag(added)
    if not np.all(np.linalg.eigvalsh(mass) > 0.0):
        return None
    return body_parameters(vehicle)._replace(
        mass=mass,
        inverse_mass=inverse(mass),
        added=np.diag(added),
        linear=linear.copy(),
        quadratic=quadratic.copy(),
    )


def vehicle_with(vehicle: Vehicle, values: Array) -> Vehicle:
    """Return the vehicle with other parameters."""
    changed: dict[str, Any] = {}
    for key, numbers in zip(KINDS, values.reshape(len(KINDS), len(AXES)), strict=True):
        groups: list[Quantity] = []
        first = 0
        for group in getattr(vehicle, key):
            after = first + len(group.value)
            own = tuple(float(one) for one in numbers[first:after])
            groups.append(replace(group, value=own, spread=None))
            first = after
        changed[key] = tuple(groups)
    return replace(vehicle, **changed)
