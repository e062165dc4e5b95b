"""Whether programs that uploads need are being installed on this machine while the service runs.

`./run` installs compilers and GNU Octave behind the pages. Until a worker has tried them, runs that
need them wait instead of being refused. What says so is a lock, which the kernel drops together
with the process that holds it.
"""

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from seamark.server.settings import Settings


@contextmanager
def announced(settings: Settings) -> Iterator[None]:
    """Let `is_under_way` say so to all processes of this machine."""
    with _lock_of(settings).open("ab") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def is_under_way(settings: Settings) -> bool:
    """Return whether programs are being installed, or have not been tried yet."""
    return is_locked(_lock_of(settings))


def is_locked(path: Path) -> bool:
    """Return whether a process holds an exclusive lock on a file."""
    try:
        with path.open("rb") as lock:
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except FileNotFoundError:
        return False
    except BlockingIOError:
        return True
    return False


def _lock_of(settings: Settings) -> Path:
    return settings.data / "installing.lock"
