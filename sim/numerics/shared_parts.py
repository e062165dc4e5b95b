"""Work that several processes share when they start at once, such as compiling the simulator.

Each takes parts that no other process is at, and does the others when they are done: what these
have compiled is then loaded.
"""

import fcntl
import tempfile
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import IO


def run_parts(
    parts: Mapping[str, Callable[[], None]],
    folder: Path,
    *,
    on_loaded: Callable[[str], None] = lambda name: None,
) -> None:
    """Run all parts; those that another process is at are left until it is done.

    Parameters
    ----------
    folder
        Of the locks, one for each part. If it cannot be written to, nothing waits.
    on_loaded
        Is called with the name of each part that is loaded.
    """

    def load(name: str) -> None:
        parts[name]()
        on_loaded(name)

    with ExitStack() as files:
        locks = {name: files.enter_context(_lock_file(folder, name)) for name in parts}
        left = [name for name in parts if not _run_if_free(partial(load, name), locks[name])]
        for name in left:
            fcntl.flock(locks[name], fcntl.LOCK_SH)
            fcntl.flock(locks[name], fcntl.LOCK_UN)  # all who waited load it at the same time
            load(name)


def _run_if_free(part: Callable[[], None], lock: IO[bytes]) -> bool:
    """Run a part and lock it meanwhile; False if another process has locked it."""
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    part()
    fcntl.flock(lock, fcntl.LOCK_UN)
    return True


def _lock_file(folder: Path, name: str) -> IO[bytes]:
    """Open the lock of a part; one of this process alone if the folder cannot be written to."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return (folder / f"warm-up-{name}.lock").open("ab")
    except OSError:
        return tempfile.TemporaryFile()
