"""Mass, buoyancy and water of a link: given, or derived from a cylinder."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from seamark.sim.vehicles import cylinder
from seamark.sim.vehicles.fields import Fields, Slot, Table, number, vector
from seamark.sim.vehicles.linkage import Body
from seamark.sim.vehicles.model import Quantity

_AXES = ("x", "y", "z")
_UNBALANCED = 1e-9  # of the largest moment: what rounding may do to a flat plate


@dataclass(frozen=True, slots=True)
class _Cylinder:
    centre: Quantity
    length: float
    radius: float
    axis: int


_Theory = Callable[[_Cylinder, float], Quantity]


def _middle(meaning: str) -> tuple[Slot, _Theory]:
    return vector(meaning, "m"), lambda one, _mass: replace(one.centre, meaning=meaning)


_NO_DRAG = Quantity(
    meaning="linear drag", value=(0.0, 0.0, 0.0), unit="N s/m", tag="E", source="not considered"
)
_MASS = number("mass", "kg", above=0.0)
# What is given, and what stands for it in a cylinder of a mass.
_NUMBERS: dict[str, tuple[Slot, _Theory]] = {
    "volume": (
        number("volume", "m³", low=0.0),
        lambda one, _: cylinder.volume_of(one.length, one.radius),
    ),
    "centre_of_mass": _middle("centre of mass"),
    "centre_of_buoyancy": _middle("centre of buoyancy"),
    "inertia": (
        Slot("inertia about the centre of mass", "kg m²", range(3, 7)),
        lambda one, mass: cylinder.inertia_of(mass, one.length, one.radius, one.axis),
    ),
    "added_mass": (
        vector("added mass", "kg", low=0.0),
        lambda one, _: cylinder.added_mass_of(one.length, one.radius, one.axis),
    ),
    "added_inertia": (
        vector("added inertia", "kg m²", low=0.0),
        lambda one, _: cylinder.added_inertia_of(one.length, one.radius, one.axis),
    ),
    "linear_drag": (vector("linear drag", "N s/m", low=0.0), lambda _cylinder, _mass: _NO_DRAG),
    "quadratic_drag": (
        vector("quadratic drag", "N s²/m²", low=0.0),
        lambda one, _: cylinder.drag_of(one.length, one.radius, one.axis),
    ),
    "turning_drag": (
        vector("quadratic drag of turning", "N m s²", low=0.0),
        lambda one, _: cylinder.turning_drag_of(one.length, one.radius, one.axis),
    ),
    "centre": _middle("centre of added mass and drag"),
}


def read_body(fields: Fields, path: str, table: Table) -> Body:
    """Return the body of a link."""
    fields.known(path, table, ("mass", "cylinder", *_NUMBERS))
    mistakes = len(fields.errors)
    round_body = _read_cylinder(fields, path, table)
    mass = fields.quantity(path, table, "mass", _MASS)
    values: dict[str, Quantity] = {}
    for key, (slot, theory) in _NUMBERS.items():
        if round_body and key not in table:
            values[key] = theory(round_body, mass.scalar)
        else:
            values[key] = fields.quantity(path, table, key, slot)
    inertia = values["inertia"]
    if len(inertia.value) not in (3, 6):
        fields.wrong(f"{path}.inertia.value must be xx, yy, zz, or these and xy, xz, yz.")
    values["inertia"] = replace(inertia, value=(*inertia.value, 0.0, 0.0, 0.0)[:6])
    body = Body(mass=mass, **values)
    if len(fields.errors) == mistakes:
        _check_inertia(fields, path, body)
    return body


def _read_cylinder(fields: Fields, path: str, body: Table) -> _Cylinder | None:
    if "cylinder" not in body:
        return None
    path, table = f"{path}.cylinder", fields.table(path, body, "cylinder", required=True)
    fields.known(path, table, ("axis", "centre", "length", "radius"))
    axis = _AXES.index(fields.choice(f"{path}.axis", table.get("axis"), _AXES))
    centre = fields.quantity(path, table, "centre", vector("centre", "m"))
    length = fields.quantity(path, table, "length", number("length", "m", above=0.0))
    radius = fields.quantity(path, table, "radius", number("radius", "m", above=0.0))
    return _Cylinder(centre, length.scalar, radius.scalar, axis)


def _check_inertia(fields: Fields, path: str, body: Body) -> None:
    """Refuse an inertia that no body has: a moment is positive and at most the others' sum."""
    xx, yy, zz, xy, xz, yz = body.inertia.value
    moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    least, middle, most = map(float, moments)
    if least <= 0.0:
        fields.wrong(
            f"{path}.inertia must be positive definite: its least principal moment is {least:g} "
            "kg m², not above 0."
        )
    elif least + middle < most * (1.0 - _UNBALANCED):
        fields.wrong(
            f"{path}.inertia is that of no body: its greatest principal moment, {most:g} kg m², is "
            f"more than the sum of the other two, {least + middle:g} kg m²."
        )
