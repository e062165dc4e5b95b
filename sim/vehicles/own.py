"""Vehicles that a user brings: read from a file, and known in this process from then on.

A run names such a vehicle by its name and the start of its file's SHA-256, as in
"my-rov@0123456789abcdef", so that no other can be taken for it. Its manifest has the file itself. A
process that serves many users adds none: it lends one for as long as it works on a run with it.
"""

import hashlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from seamark.sim.files.library import TextFile, name_digits
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import Vehicle, added, lent, load
from seamark.sim.vehicles.plausibility import findings
from seamark.sim.vehicles.reading import VehicleInvalid, read_vehicle
from seamark.sim.vehicles.toml_reading import BYTES_MAX

SUFFIX = ".toml"
SETTING = "vehicle"
_MARK = "@"
_KEPT = 16  # vehicles of which each is at most a few hundred KiB


class OwnVehicle(NamedTuple):
    """A vehicle that may be used, and the name by which settings choose it."""

    name: str
    vehicle: Vehicle
    file: TextFile


_FILES: dict[str, TextFile] = {}
_LENT_FILES: ContextVar[Mapping[str, TextFile]] = ContextVar(
    "_LENT_FILES", default=MappingProxyType({})
)


def add(content: bytes) -> str:
    """Add a vehicle to this process and return the name by which settings choose it.

    Raises
    ------
    VehicleInvalid
        Its file breaks a rule, has the name of one of ours, or no such body exists.
    """
    name, vehicle, file = usable(content)
    added[name], _FILES[name] = vehicle, file
    return name


@contextmanager
def lending(content: bytes) -> Iterator[str]:
    """Let this thread use a vehicle meanwhile, and nothing else in this process.

    Raises
    ------
    VehicleInvalid
        As `add`.
    """
    name, vehicle, file = usable(content)
    before = lent.set({**lent.get(), name: vehicle})
    files_before = _LENT_FILES.set({**_LENT_FILES.get(), name: file})
    try:
        yield name
    finally:
        lent.reset(before)
        _LENT_FILES.reset(files_before)


@lru_cache(maxsize=_KEPT)
def usable(content: bytes) -> OwnVehicle:
    """Return the vehicle of a file if it can run; raises VehicleInvalid as `add`."""
    vehicle = read(content)
    errors = [finding.text for finding in findings(vehicle) if finding.grade == "error"]
    if errors:
        raise VehicleInvalid(errors)
    file = TextFile(hashlib.sha256(content).hexdigest(), content.decode("utf-8"))
    return OwnVehicle(name_of(vehicle, content), vehicle, file)


def read(content: bytes) -> Vehicle:
    """Return the vehicle of a file, which perhaps cannot exist.

    Raises
    ------
    VehicleInvalid
        Its file breaks a rule, or has the name of one of ours.
    """
    vehicle = read_vehicle(content, base=load)
    if vehicle.name in VEHICLES:
        raise VehicleInvalid(
            [f"name: {vehicle.name} is a vehicle of Seamark; give yours another name."]
        )
    return vehicle


def name_of(vehicle: Vehicle, content: bytes) -> str:
    """Return the name by which settings choose the vehicle of a file."""
    return f"{vehicle.name}{_MARK}{name_digits(content)}"


def is_own(name: object) -> bool:
    """Return whether a setting names a user's vehicle, known here or not."""
    return isinstance(name, str) and _MARK in name


def file_of(name: object) -> TextFile | None:
    """Return the file of a vehicle that was added or lent; None for any other value."""
    if not isinstance(name, str):
        return None
    return _LENT_FILES.get().get(name) or _FILES.get(name)


def resolved(settings: Mapping[str, object]) -> dict[str, object]:
    """Return settings in which a vehicle's file is replaced by the name of the vehicle, added.

    Raises
    ------
    VehicleInvalid
        The file cannot be read, or breaks a rule.
    """
    chosen = settings.get(SETTING)
    if not isinstance(chosen, str | Path) or not str(chosen).endswith(SUFFIX):
        return dict(settings)
    return {**settings, SETTING: add(content_of(Path(chosen)))}


def content_of(path: Path) -> bytes:
    """Return the content of a file, no more than is read of a vehicle; raises VehicleInvalid."""
    try:
        with path.open("rb") as file:
            return file.read(BYTES_MAX + 1)
    except OSError as error:
        raise VehicleInvalid([f"The file cannot be read: {error.strerror}."]) from None
