"""The files of a run that has no number yet: written aside, then moved into their place at once.

So a transaction that inserts a run takes as long for many files as for few. What a crash leaves
aside is removed after a day, by whoever writes aside next.
"""

import json
import os
import secrets
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import structlog

from seamark.server.runs.data import run_objects
from seamark.server.runs.data.files import RunFiles, StorageFailed
from seamark.server.settings import Settings
from seamark.server.storage import objects, storage
from seamark.server.storage.objects import Objects, ObjectsAway

FOLDER = "staged"
LEFT_S = 86_400.0  # nothing takes so long: what is older is left of a crash
_log = structlog.get_logger()


class Staged:
    """Files aside, in the data folder and, if there is one, in the object storage."""

    def __init__(self, settings: Settings, name: str, attempt: int) -> None:
        self._data = storage.copies(settings)
        self._stored = objects.of(settings)
        self._path = f"{FOLDER}/{name}"  # of the objects
        self._folder = self._data / FOLDER / name
        self._attempt = attempt
        self.files = RunFiles(self._folder, 0, attempt)

    def make(self) -> None:
        """Make the folder, and remove what has been left; raises StorageFailed, ObjectsAway."""
        try:
            self._folder.parent.mkdir(exist_ok=True)
            _remove_left(self._folder.parent)
            self._folder.mkdir()
        except OSError as error:
            raise StorageFailed(f"{FOLDER}: {error.strerror}") from error
        if self._stored is not None:
            _remove_left_objects(self._stored)

    def upload(self) -> None:
        """Store the files aside in the object storage, if there is one; raises ObjectsAway."""
        if self._stored is not None:
            for name in self._names():
                self._stored.put(f"{self._path}/{name}", self.files.folder / name)

    def place(self, run_id: int) -> None:
        """Make them the files of a run; raises StorageFailed, ObjectsAway.

        Whatever a run had that was never committed and had the same number is replaced.
        """
        if self._stored is not None:
            self._place_objects(self._stored, run_id)
            return
        target = RunFiles(self._data, run_id, self._attempt)
        try:
            for folder in (self._data / "runs", target.root.parent, target.root):
                folder.mkdir(exist_ok=True)
            target.remove()
            os.rename(self.files.folder, target.folder)
        except OSError as error:
            raise StorageFailed(f"{target.folder}: {error.strerror}") from error

    def _place_objects(self, stored: Objects, run_id: int) -> None:
        run_objects.remove(stored, run_id)
        folder = run_objects.folder(run_id, self._attempt)
        for name in self._names():
            stored.copy(f"{self._path}/{name}", f"{folder}/{name}")
        stored.put(f"{folder}/{run_objects.COMPLETE}", json.dumps(self._names()).encode())

    def remove(self) -> None:
        """Remove what is still aside; what cannot be reached now is removed by a later use."""
        shutil.rmtree(self._folder, ignore_errors=True)
        if self._stored is None:
            return
        try:
            self._stored.delete([one.path for one in self._stored.list(self._path)])
        except ObjectsAway as error:
            _log.warning("objects_not_removed", folder=self._path, error=str(error))

    def _names(self) -> list[str]:
        return sorted(file.name for file in self.files.folder.iterdir())


@contextmanager
def staged(settings: Settings, *, attempt: int) -> Iterator[Staged]:
    """Yield files aside, which are removed at the end unless they have been moved.

    Raises
    ------
    StorageFailed, ObjectsAway
        They cannot be written.
    """
    aside = Staged(settings, secrets.token_hex(8), attempt)
    try:
        aside.make()
        yield aside
    finally:
        aside.remove()


@contextmanager
def temporary_folder(settings: Settings) -> Iterator[Path]:
    """Yield a folder on the disk of the data, which is removed at the end.

    Temporary folders of the system are often in memory. Raises StorageFailed.
    """
    parent = storage.copies(settings) / FOLDER
    try:
        parent.mkdir(exist_ok=True)
        _remove_left(parent)
        folder = tempfile.TemporaryDirectory(dir=parent, ignore_cleanup_errors=True)
    except OSError as error:
        raise StorageFailed(f"{FOLDER}: {error.strerror}") from error
    with folder as name:
        yield Path(name)


def _remove_left(folder: Path) -> None:
    for entry in folder.iterdir():
        with suppress(FileNotFoundError):  # others remove theirs
            if entry.stat().st_mtime < time.time() - LEFT_S:
                shutil.rmtree(entry, ignore_errors=True)


def _remove_left_objects(stored: Objects) -> None:
    left = [one.path for one in stored.list(FOLDER) if one.changed_at < time.time() - LEFT_S]
    stored.delete(left)
