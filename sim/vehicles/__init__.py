"""Vehicles as data: a file each, with the source of every number.

Adding a vehicle is one TOML file here (`docs/vehicles.md`); the registry finds it. This package
needs no compiled code: forms and documentation read it as well.
"""

from functools import cache

from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles.model import (
    AXES,
    STANDARD_GRAVITY,
    TAGS,
    HullBox,
    Quantity,
    Tag,
    ThrustCurve,
    Thruster,
    Vehicle,
)
from seamark.sim.vehicles.reading import read_vehicle

__all__ = [
    "AXES",
    "STANDARD_GRAVITY",
    "TAGS",
    "HullBox",
    "Quantity",
    "Tag",
    "ThrustCurve",
    "Thruster",
    "Vehicle",
    "added",
    "load",
    "most_thrusters",
]

added: dict[str, Vehicle] = {}  # by users, to this process (`own`)


def load(name: str) -> Vehicle:
    """Return the vehicle of that name, such as "girona500-uwsim".

    Raises
    ------
    LookupError
        There is no such vehicle in the registry, and none was added.
    """
    return added[name] if name in added else _read(name, ())


@cache
def _read(name: str, extending: tuple[str, ...]) -> Vehicle:
    """Return the vehicle of a file, which others that are being read extend."""
    if name not in VEHICLES:
        raise LookupError(f"there is no vehicle called {name!r}")
    if name in extending:
        raise LookupError(f"{name} extends itself")
    return read_vehicle(
        VEHICLES[name].read_bytes(), base=lambda extended: _read(extended, (*extending, name))
    )


def most_thrusters() -> int:
    """Return the largest number of thrusters of any registered vehicle."""
    return max(len(load(name).thrusters) for name in VEHICLES)
