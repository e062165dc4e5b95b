"""Settings that a file of the user's own can take the place of: vehicle, record, target picture."""

from collections.abc import Mapping
from contextlib import AbstractContextManager
from typing import Any

from seamark.sim.files import target_pictures
from seamark.sim.files.library import FileInvalid, Library, name_digits
from seamark.sim.physics.water_motion import records
from seamark.sim.vehicles import own
from seamark.sim.vehicles.reading import VehicleInvalid

INVALID = (VehicleInvalid, FileInvalid)  # what the functions here raise of a file
LIBRARIES: Mapping[str, Library[Any]] = {  # of all but vehicles, which have names of their own
    one.setting: one for one in (records.LIBRARY, target_pictures.LIBRARY)
}


ADVICE = {  # a sentence to add where a value of such a setting is refused
    records.LIBRARY.setting: " A record of your own is chosen by its file: seamark run BENCHMARK "
    "--set current_record=FILE.csv; `seamark current` writes such a file.",
    target_pictures.LIBRARY.setting: " A picture of your own is chosen by its file: seamark run "
    "BENCHMARK --set target_texture=FILE.png; a competition has that of its organiser.",
}
SETTINGS = (own.SETTING, *LIBRARIES)


def is_own(setting: str, value: object) -> bool:
    """Return whether a setting names a file of a user's, known here or not."""
    if setting == own.SETTING:
        return own.is_own(value)
    return setting in LIBRARIES and LIBRARIES[setting].is_own(value)


def is_named(name: str, content: bytes) -> bool:
    """Return whether the name of a user's file is that of this content, which may be none."""
    return name.rpartition("@")[2] == name_digits(content)


def add(setting: str, content: bytes) -> str:
    """Add a file to this process and return the value of the setting that chooses it.

    Raises
    ------
    VehicleInvalid, FileInvalid
        The file breaks a rule.
    """
    return own.add(content) if setting == own.SETTING else LIBRARIES[setting].add(content)


def lending(setting: str, content: bytes) -> AbstractContextManager[str]:
    """Let this thread use a file meanwhile, and nothing else in this process; raises as `add`."""
    if setting == own.SETTING:
        return own.lending(content)
    return LIBRARIES[setting].lending(content)


def resolved(settings: Mapping[str, object]) -> dict[str, object]:
    """Return settings in which files are replaced by the names of what is in them, added.

    Raises
    ------
    VehicleInvalid, FileInvalid
        A file cannot be read, or breaks a rule.
    """
    found = own.resolved(settings)
    for library in LIBRARIES.values():
        found = library.resolved(found)
    return found
