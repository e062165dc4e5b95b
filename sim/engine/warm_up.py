"""Load everything that a run needs, so that a process forked afterwards starts at once.

Where nothing is compiled yet, several processes do that together: each takes parts that no other
process is at, and loads the others when they are done.
"""

import fcntl
import os
import tempfile
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import IO

import cv2

from seamark.sim import registry, trackers
from seamark.sim.engine.trial import run_trial
from seamark.sim.numerics.numba_internals import numba_folder
from seamark.sim.physics import plant


def warm_up() -> None:
    """Load all registry entries and compiled code, and run each benchmark's shortest trial once."""
    registry.load_all()
    # A run has one core, and threads that are made before a fork are not there after it.
    cv2.setNumThreads(1)
    # Large parts first; the registry lists the newest benchmarks first, and the others need less.
    parts = {"plant": plant.warm_up, "trackers": trackers.warm_up}
    parts |= {name: partial(_shortest_trial, name) for name in registry.BENCHMARKS}
    run_parts(parts, numba_folder(os.environ))


def warm_up_benchmark(name: str) -> None:
    """Load what runs of one benchmark need with its defaults."""
    cv2.setNumThreads(1)
    run_parts({name: partial(_shortest_trial, name)}, numba_folder(os.environ))


def run_parts(parts: Mapping[str, Callable[[], None]], folder: Path) -> None:
    """Run all parts; those that another process is at are left until it is done.

    Parameters
    ----------
    folder
        Of the locks, one for each part. If it cannot be written to, nothing waits.
    """
    with ExitStack() as files:
        locks = {name: files.enter_context(_lock_file(folder, name)) for name in parts}
        left = [name for name in parts if not _run_if_free(parts[name], locks[name])]
        for name in left:
            fcntl.flock(locks[name], fcntl.LOCK_SH)
            fcntl.flock(locks[name], fcntl.LOCK_UN)  # all who waited load it at the same time
            parts[name]()


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


def _shortest_trial(name: str) -> None:
    benchmark = registry.benchmark(name)
    config = benchmark.read(benchmark.quick_settings)
    solution = benchmark.load().built_in(next(iter(benchmark.built_in)), config)
    run_trial(name, config, solution, seed=0, trial=0, on_rows=lambda _rows: None)
