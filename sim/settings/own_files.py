"""Settings that a file of the user's own can take the place of: a vehicle, a record of currents."""

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from typing import NamedTuple

from seamark.sim.physics.water_motion import records
from seamark.sim.physics.water_motion.record import RecordInvalid
from seamark.sim.vehicles import own
from seamark.sim.vehicles.reading import VehicleInvalid

INVALID = (VehicleInvalid, RecordInvalid)  # what the functions here raise of a file


class _Kind(NamedTuple):
    add: Callable[[bytes], str]
    lending: Callable[[bytes], AbstractContextManager[str]]


_KINDS = {
    own.SETTING: _Kind(own.add, own.lending),
    records.SETTING: _Kind(records.add, records.lending),
}


def add(setting: str, content: bytes) -> str:
    """Add a file to this process and return the value of the setting that chooses it.

    Raises
    ------
    VehicleInvalid, RecordInvalid
        The file breaks a rule.
    """
    return _KINDS[setting].add(content)


def lending(setting: str, content: bytes) -> AbstractContextManager[str]:
    """Let this thread use a file meanwhile, and nothing else in this process; raises as `add`."""
    return _KINDS[setting].lending(content)


def resolved(settings: Mapping[str, object]) -> dict[str, object]:
    """Return settings in which files are replaced by the names of what is in them, added.

    Raises
    ------
    VehicleInvalid, RecordInvalid
        A file cannot be read, or breaks a rule.
    """
    return records.resolved(own.resolved(settings))
