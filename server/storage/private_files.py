"""What a service keeps in its data folder is for its owner alone.

What processes write now is so by their umask. This is about what earlier versions wrote, or what
somebody copied, in a folder that others may enter.
"""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from sqlalchemy import make_url

from seamark.server.settings import KEY_FILES, Settings

OTHERS = 0o077  # bits of the group and of everybody else
# Folders that others cannot enter hide what is in them. No box is given a path in the data folder.
_FOLDERS = ("runs", "programs", "broker", "logs", "cache", "workspace", "staged", "compiled")
_FILES = (*KEY_FILES.values(), "seamark-data", "up.lock", "installing.lock", "programs.lock")
_OF_SQLITE = ("", "-wal", "-shm", "-journal")


def tighten(settings: Settings) -> None:
    """Take away what others may do with what is the service's own, where this process may."""
    for path in open_to_others(settings):
        with suppress(OSError):  # of another user: `seamark doctor` says so
            path.chmod(path.stat().st_mode & ~OTHERS)


def open_to_others(settings: Settings) -> list[Path]:
    """Return what of the service's own others may read, write or enter."""
    return [path for path in _own(settings) if path.exists() and path.stat().st_mode & OTHERS]


def _own(settings: Settings) -> Iterator[Path]:
    for name in (*_FOLDERS, *_FILES):
        yield settings.data / name
    url = make_url(settings.database_url)
    if url.drivername.startswith("sqlite") and url.database:
        for suffix in _OF_SQLITE:
            yield Path(url.database + suffix)
