"""The storage of the service: whether it is there, and whether this machine's disk has room.

A mark in the data folder tells it from the empty folder that remains when its disk is not mounted.
With object storage the mark is an object, and the data folder holds only what can be lost.
"""

import os
import tempfile
from pathlib import Path

from seamark.server.settings import Settings
from seamark.server.storage import objects

STOP_SHARE = 0.25  # of `free_min_bytes`: below it, running runs stop; the database needs the rest
RETRY_S = 60
_PROBE = bytes(64 * 1024)  # more than a file system keeps in its own records
_AWAY = "The service cannot access its data folder at the moment. Try again later."
_LOW = (
    "The service has too little free disk space to accept anything new at the moment. Try again "
    "later: the operator has to free or add space."
)


class StorageUnavailable(Exception):
    """Nothing can be stored or read at the moment. The text is for the user."""


def refusal(settings: Settings, *, share: float = 1.0) -> str | None:
    """Return why nothing new can be stored, for the user; None if all is well.

    Parameters
    ----------
    share
        Of `settings.free_min_bytes`: less free space than this is too little.
    """
    if is_away(settings):
        return _AWAY
    return machine_refusal(settings, share=share)


def machine_refusal(settings: Settings, *, share: float = 1.0) -> str | None:
    """Return why this machine can store nothing, wherever it goes later; None if all is well.

    Never waits for an object storage.
    """
    if _folder_is_away(settings):
        return _AWAY
    return _LOW if free_bytes(settings.data) < share * settings.free_min_bytes else None


def require(settings: Settings) -> None:
    """Raise StorageUnavailable if nothing new can be stored."""
    if why := refusal(settings):
        raise StorageUnavailable(why)


def require_readable(settings: Settings) -> None:
    """Raise StorageUnavailable if the data folder is away; a full disk can be read."""
    if is_away(settings):
        raise StorageUnavailable(_AWAY)


def is_away(settings: Settings) -> bool:
    """Return whether the storage cannot be used.

    The data folder is missing, not mounted, read-only or not permitted, or the object storage does
    not answer.
    """
    stored = objects.of(settings)
    return _folder_is_away(settings) or not (stored is None or stored.answers())


def _folder_is_away(settings: Settings) -> bool:
    data = settings.data
    if not os.access(data, os.R_OK | os.W_OK | os.X_OK):
        return True
    return objects.of(settings) is None and not mark(data).is_file()


def worker_refusal(settings: Settings, *, share: float = 1.0) -> str | None:
    """Return why a worker cannot store the data of a run, for its log; None if all is well.

    Unlike `refusal` it writes something: a quota of the disk shows only then.
    """
    if why := refusal(settings, share=share):
        return why
    try:
        with tempfile.TemporaryFile(dir=workspace(settings), buffering=0) as file:
            if file.write(_PROBE) == len(_PROBE):
                return None
            return "the disk takes only a part of what is written"
    except OSError as error:
        return f"nothing can be written: {error.strerror}"


def copies(settings: Settings) -> Path:
    """Return the folder from which runs and programs are read: the truth, or copies of it."""
    return settings.data if objects.of(settings) is None else _made(settings.data / "cache")


def workspace(settings: Settings) -> Path:
    """Return the folder into which a worker writes a run: the truth, or what it then uploads."""
    return settings.data if objects.of(settings) is None else _made(settings.data / "workspace")


def _made(folder: Path) -> Path:
    folder.mkdir(exist_ok=True)
    return folder


def free_bytes(data: Path) -> int:
    """Return how many bytes can still be stored; 0 if that cannot be found out."""
    try:
        statistics = os.statvfs(data)
    except OSError:
        return 0
    return statistics.f_bavail * statistics.f_frsize


def mark(data: Path) -> Path:
    """Return the file by which the data folder is known."""
    return data / "seamark-data"
