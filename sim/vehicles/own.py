"""Vehicles that a user brings: read from a file, and known in this process from then on.

A run names such a vehicle by its name and the start of its file's SHA-256, as in
"my-rov@0123456789abcdef", so that no other can be taken for it. Its manifest has the file itself. A
service adds none: there, only the vehicles of the registry can be chosen.
"""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import added, load
from seamark.sim.vehicles.plausibility import findings
from seamark.sim.vehicles.reading import VehicleInvalid, read_vehicle
from seamark.sim.vehicles.toml_reading import BYTES_MAX

SUFFIX = ".toml"
SETTING = "vehicle"
_HASH_DIGITS = 16


class VehicleFile(NamedTuple):
    """What a manifest has of a user's own vehicle."""

    sha256: str
    text: str


_FILES: dict[str, VehicleFile] = {}


def add(content: bytes) -> str:
    """Add a vehicle and return the name by which settings choose it.

    Raises
    ------
    VehicleInvalid
        Its file breaks a rule, has the name of one of ours, or no such body exists.
    """
    vehicle = read_vehicle(content, base=load)
    if vehicle.name in VEHICLES:
        raise VehicleInvalid(
            [f"name: {vehicle.name} is a vehicle of Seamark; give yours another name."]
        )
    errors = [finding.text for finding in findings(vehicle) if finding.grade == "error"]
    if errors:
        raise VehicleInvalid(errors)
    sha256 = hashlib.sha256(content).hexdigest()
    name = f"{vehicle.name}@{sha256[:_HASH_DIGITS]}"
    added[name] = vehicle
    _FILES[name] = VehicleFile(sha256, content.decode("utf-8"))
    return name


def file_of(name: object) -> VehicleFile | None:
    """Return the file of a vehicle that was added; None for any other value."""
    return _FILES.get(name) if isinstance(name, str) else None


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
