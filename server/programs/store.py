"""The programs of all runs, stored under their SHA-256 in normal form; never run here.

Vehicles that users upload are stored here too (`vehicles`).

With object storage the folder has copies: a program that is missing is fetched, and compared with
its SHA-256.
"""

import fcntl
import hashlib
import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from seamark.drafts import replace_file
from seamark.programs.parameters import Parameter
from seamark.programs.preparation import PreparedProgram
from seamark.server.settings import Settings
from seamark.server.storage import objects, storage
from seamark.server.storage.objects import Objects, ObjectsAway
from seamark.server.storage.storage import StorageUnavailable

_SHA256 = re.compile(r"[0-9a-f]{64}")
# Until `delete_unused` may delete a program. Short, because programs that are only checked, or
# whose form was never corrected, count towards nobody's disk space.
UNUSED_KEPT_S = 7200.0


class ProgramDamaged(StorageUnavailable):
    """What is stored under the key of a program is something else."""


@dataclass(frozen=True, slots=True)
class StoredProgram:
    """A program in the store."""

    sha256: str
    name: str
    language: str
    size: int  # [B]
    parameters: tuple[Parameter, ...] = ()  # that it declares


def save(prepared: PreparedProgram, settings: Settings) -> StoredProgram:
    """Put a program into the store, or renew one that is already there.

    Raises
    ------
    StorageUnavailable
        There is no room for it, or the data folder is away.
    """
    sha256 = save_content(prepared.content, settings)
    names, size = (prepared.name, prepared.language), len(prepared.content)
    return StoredProgram(sha256, *names, size=size, parameters=prepared.parameters)


def save_content(content: bytes, settings: Settings) -> str:
    """Put a program or another upload into the store and return its SHA-256; raises as `save`."""
    storage.require(settings)
    sha256 = hashlib.sha256(content).hexdigest()
    with _store_lock(settings, fcntl.LOCK_SH):
        _write(content, _file(settings, sha256))
    stored = objects.of(settings)
    if stored is not None and not _renew_object(stored, sha256):
        with _reaching():
            stored.put(_key(sha256), content)
    return sha256


def path(settings: Settings, sha256: str) -> Path:
    """Return the file of the program with this key; if the program is gone, there is no such file.

    Raises
    ------
    StorageUnavailable
        It could not be fetched.
    ProgramDamaged
    """
    file, stored = _file(settings, sha256), objects.of(settings)
    if stored is None or file.exists():
        return file
    with _reaching():
        content = stored.get(_key(sha256))
    if content is None:
        return file
    if hashlib.sha256(content).hexdigest() != sha256:
        raise ProgramDamaged("The stored program has been damaged.")
    with _store_lock(settings, fcntl.LOCK_SH):
        _write(content, file)
    return file


def read(settings: Settings, sha256: str) -> bytes:
    """Return the content of a program; raises FileNotFoundError if it is not in the store."""
    return path(settings, sha256).read_bytes()


def size(settings: Settings, sha256: str) -> int:
    """Return the size of a program [B], 0 if it is not in the store."""
    try:
        return path(settings, sha256).stat().st_size
    except FileNotFoundError:
        return 0


def touch(settings: Settings, sha256: str) -> int | None:
    """Reset the age of a program, so that it is not deleted soon, and return its size [B].

    None if it is gone.
    """
    stored = objects.of(settings)
    if stored is not None and not _renew_object(stored, sha256):
        return None
    file = path(settings, sha256)
    with _store_lock(settings, fcntl.LOCK_SH):
        return file.stat().st_size if _renew(file) else None


def delete_unused(
    settings: Settings, *, used: Callable[[str], bool], older_than_s: float = UNUSED_KEPT_S
) -> int:
    """Delete old programs that nothing refers to; return how many.

    The age counts from the last upload or `touch`: the submission that will refer to a recent
    program may still be in progress. Uploads and other workers' deletions may run at the same
    time, so any file may vanish between listing the folder and taking the lock.
    """
    deleted, limit = (
        _delete_unused_objects(settings, used, older_than_s),
        time.time() - older_than_s,
    )
    for file in (storage.copies(settings) / "programs").glob("*"):
        if not _is_older(file, limit) or used(file.name):
            continue
        with _store_lock(settings, fcntl.LOCK_EX):
            if _is_older(file, limit):  # it may have been uploaded again in the meantime
                file.unlink()
                deleted += 1
    return deleted


def _delete_unused_objects(
    settings: Settings, used: Callable[[str], bool], older_than_s: float
) -> int:
    stored, limit = objects.of(settings), time.time() - older_than_s
    if stored is None:
        return 0
    old = [one for one in stored.list("programs") if one.changed_at < limit]
    unused = [one.path for one in old if not used(one.path.rpartition("/")[2])]
    gone = [key for key in unused if (one := stored.find(key)) and one.changed_at < limit]
    stored.delete(gone)
    return len(gone)


def _renew_object(stored: Objects, sha256: str) -> bool:
    """Store an object again that would soon be old enough to be deleted; False if it is gone."""
    with _reaching():
        kept = stored.find(_key(sha256))
        if kept is None:
            return False
        if kept.changed_at > time.time() - UNUSED_KEPT_S / 2:
            return True
        content = stored.get(_key(sha256))
        if content is not None:
            stored.put(_key(sha256), content)
        return content is not None


def _file(settings: Settings, sha256: str) -> Path:
    if not _SHA256.fullmatch(sha256):
        raise ValueError(f"not a SHA-256: {sha256!r}")
    return storage.copies(settings) / "programs" / sha256


def _key(sha256: str) -> str:
    return f"programs/{sha256}"


@contextmanager
def _reaching() -> Iterator[None]:
    try:
        yield
    except ObjectsAway as error:
        raise StorageUnavailable("Programs cannot be stored or read at the moment.") from error


def _is_older(file: Path, limit: float) -> bool:
    """Return whether the file exists and was last written or touched before `limit`."""
    try:
        return file.stat().st_mtime < limit
    except FileNotFoundError:
        return False


def _renew(file: Path) -> bool:
    """Set the file's time to now; False if there is no such file."""
    try:
        os.utime(file)
    except FileNotFoundError:
        return False
    return True


@contextmanager
def _store_lock(settings: Settings, mode: int) -> Iterator[None]:
    """Lock the store: shared (LOCK_SH) to add programs, exclusive (LOCK_EX) to delete them."""
    data = storage.copies(settings)
    folder = data / "programs"
    folder.mkdir(exist_ok=True)
    with (data / "programs.lock").open("a") as lock:
        fcntl.flock(lock, mode)
        yield


def _write(content: bytes, target: Path) -> None:
    """Write the file atomically, or renew it if it exists."""
    if _renew(target):
        return
    try:
        replace_file(target, content)
    except OSError as error:
        raise StorageUnavailable(f"The program could not be stored: {error.strerror}.") from error
