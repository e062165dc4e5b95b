"""Vehicles as data: a file each, with the source of every number.

Adding a vehicle is one TOML file here (`docs/vehicles.md`); the registry finds it. This package
needs no compiled code: forms and documentation read it as well.
"""

from collections.abc import Mapping
from contextvars import ContextVar
from functools import cache
from types import MappingProxyType

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
    "is_known",
    "lent",
    "load",
    "most_thrusters",
]

added: dict[str, Vehicle] = {}  # by users, to this process (`own`)
# By users, to what is done at the moment for one of them in a process that serves many.
lent: ContextVar[Mapping[str, Vehicle]] = ContextVar("lent", default=MappingProxyType({}))


def load(name: str) -> Vehicle:
    """Return the vehicle of that name, such as "girona500-uwsim".

    Raises
    ------
    LookupError
        There is no such vehicle in the registry, and none was added or lent.
    """
    return lent.get().get(name) or added.get(name) or _read(name, ())


def is_known(name: object) -> bool:
    """Return whether `load` returns a vehicle of this name now."""
    return isinstance(name, str) and (name in VEHICLES or name in added or name in lent.get())


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
