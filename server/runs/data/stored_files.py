"""The files of a run for those who read them, wherever they are kept.

With object storage they are copied into a folder of this machine when somebody asks for them: once,
however many ask, and of a run that is going on only what has been added. What a watched run records
comes through the broker before it is stored, and the storage heals what was lost on the way.
"""

import fcntl
import os
import shutil
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Protocol

import structlog

from seamark.server.messaging.live_data import Increment
from seamark.server.runs.data import run_objects
from seamark.server.runs.data.attempt_copy import AttemptCopy
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.data.run_objects import Attempt
from seamark.server.runs.record.states import RunState
from seamark.server.settings import Settings
from seamark.server.storage import objects, storage
from seamark.server.storage.objects import Objects, ObjectsAway

LIST_EVERY_S = 1.0  # between two looks at the objects of a run that has not ended
SETTLED_S = 600.0  # after which files without the sign of their end are taken for complete
KEPT_S = 3600.0  # copies that somebody read within this time are not removed
UNREAD_S = 86_400.0  # after which a copy goes, even if there is room for it
TRIM_EVERY_S = 60.0
LOCKS = 64
_COMPLETE = ".complete"  # a copy that needs no look at the storage any more
_LOOKED = ".looked"  # when the copy was known to have everything
_log = structlog.get_logger()


class Stored(Protocol):
    """A run that may have files."""

    @property
    def id(self) -> int: ...  # noqa: D102 - the attribute of tables.Run
    @property
    def data_id(self) -> int: ...  # noqa: D102
    @property
    def attempt(self) -> int: ...  # noqa: D102
    @property
    def state(self) -> RunState: ...  # noqa: D102
    @property
    def hidden_names(self) -> tuple[str, ...]: ...  # noqa: D102 - while the run is anonymous


def of_run(settings: Settings, run: Stored) -> RunFiles:
    """Return the files of a run, as they are now."""
    known = run.state.final and run.data_id == run.id  # else: the attempt of another run
    files = latest(settings, run.data_id, run.attempt if known else None)
    files.hidden = run.hidden_names
    return files


def latest(settings: Settings, run_id: int, attempt: int | None = None) -> RunFiles:
    """Return the files of a run as they are now.

    While the object storage does not answer, they are what this machine has copied before.

    Parameters
    ----------
    attempt
        That of the result; None while the run has not ended, for the newest that has files.
    """
    stored = objects.of(settings)
    if stored is None:
        return RunFiles(settings.data, run_id)
    data = storage.copies(settings)
    try:
        _refresh(stored, data, run_id, attempt)
        _trim(data, settings.cache_bytes)
    except ObjectsAway as error:
        _log.warning("objects_away", run=run_id, error=str(error))
    return RunFiles(data, run_id, attempt)


def _refresh(stored: Objects, data: Path, run_id: int, attempt: int | None) -> None:
    if attempt is not None and _is_complete(RunFiles(data, run_id, attempt).folder):
        return
    with _locked(data, run_id):
        # Others may have copied it while this one waited for the lock.
        if attempt is not None and _is_complete(RunFiles(data, run_id, attempt).folder):
            return
        looked = RunFiles(data, run_id).root / _LOOKED
        if attempt is None and _age_s(looked) < LIST_EVERY_S:
            return
        # Whoever had the lock may have waited in vain; the next ones need not do so in turn.
        if not stored.answers():
            raise ObjectsAway("the storage does not answer")
        _copy(stored, data, run_id, attempt)
        looked.parent.mkdir(parents=True, exist_ok=True)
        looked.touch()


def _copy(stored: Objects, data: Path, run_id: int, attempt: int | None) -> None:
    attempts = run_objects.attempts(stored, run_id)
    chosen = max(attempts, default=0) if attempt is None else attempt
    files = RunFiles(data, run_id, chosen)
    files.remove_earlier_attempts()
    if chosen not in attempts:
        return
    files.folder.mkdir(parents=True, exist_ok=True)
    copy = AttemptCopy(files.folder)
    copy.take_whole(stored, attempts[chosen])
    if attempts[chosen].complete or not attempts[chosen].parts:
        if attempt is not None and _will_not_change(attempts[chosen]):
            (files.folder / _COMPLETE).touch()
    else:
        copy.take_parts(stored, attempts[chosen])


def append(settings: Settings, run_id: int, increments: Sequence[Increment]) -> bool:
    """Add what a worker has published to the copies; False if something before it is missing.

    As long as nothing is, nobody has to look at the storage.
    """
    data = storage.copies(settings)
    with _locked(data, run_id):
        if not all(_append(data, run_id, one) for one in increments):
            return False
        if increments:
            (RunFiles(data, run_id).root / _LOOKED).touch()
    return True


def _append(data: Path, run_id: int, increment: Increment) -> bool:
    files = RunFiles(data, run_id, increment.attempt)
    if increment.attempt < RunFiles(data, run_id).attempt or _is_complete(files.folder):
        return True
    files.remove_earlier_attempts()
    files.folder.mkdir(parents=True, exist_ok=True)
    copy = AttemptCopy(files.folder)
    return copy.is_whole or copy.take_increment(increment)


def _will_not_change(attempt: Attempt) -> bool:
    """Return whether the worker has stored everything, or has been silent for long."""
    return attempt.complete or attempt.changed_at < time.time() - SETTLED_S


def _is_complete(folder: Path) -> bool:
    """Return whether a copy is complete, and note that somebody reads it."""
    try:
        os.utime(folder / _COMPLETE)
    except FileNotFoundError:
        return False
    return True


def _age_s(file: Path) -> float:
    try:
        return abs(time.time() - file.stat().st_mtime)
    except FileNotFoundError:
        return float("inf")


@contextmanager
def _locked(data: Path, run_id: int) -> Iterator[None]:
    """Hold the lock of a run among the threads and processes that share the copies."""
    folder = data / "locks"
    folder.mkdir(exist_ok=True)
    with (folder / str(run_id % LOCKS)).open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _trim(data: Path, limit: int) -> None:
    """Remove the copies that nobody has read for long: beyond `limit` bytes, and after a day.

    After a day also what has meanwhile been deleted on another machine is gone from this one.
    """
    last = data / "trimmed"
    if _age_s(last) < TRIM_EVERY_S:
        return
    last.touch()
    copies = sorted(_copies(data / "runs"))
    excess = sum(size for _, size, _ in copies) - limit
    for read_at, size, folder in copies:
        unread_s = time.time() - read_at
        if unread_s < UNREAD_S and (excess <= 0 or unread_s < KEPT_S):
            return
        shutil.rmtree(folder, ignore_errors=True)
        excess -= size


def _copies(runs: Path) -> Iterator[tuple[float, int, Path]]:
    """Yield when each copy of a run was read, its bytes and its folder."""
    for folder in runs.glob("*/*"):
        stats: Sequence[os.stat_result] = []
        with suppress(FileNotFoundError):
            stats = [file.stat() for file in folder.rglob("*") if file.is_file()]
        if stats:
            yield max(one.st_mtime for one in stats), sum(one.st_size for one in stats), folder
