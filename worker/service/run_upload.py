"""Between a worker and the object storage: programs come, the files of a run go.

Of a run that goes on parts are stored, at its end the whole files.

Nothing here stops a run: while the storage is away its files wait on the worker's disk. Only at the
end they must get there, before the result is stored.
"""

import json
import threading
import time
from collections.abc import Callable
from pathlib import Path

import structlog
from redis import Redis
from sqlalchemy.orm import Session

from seamark.server import storage
from seamark.server.database import data_folder
from seamark.server.database.data_folder import WrongDataFolder
from seamark.server.objects import Objects, ObjectsAway
from seamark.server.programs import store
from seamark.server.runs import run_objects
from seamark.server.runs.files import RunFiles, StorageFailed
from seamark.server.runs.run_objects import COMPLETE, GROWING, REPLACED
from seamark.server.settings import Settings
from seamark.server.storage import StorageUnavailable
from seamark.worker.service.growing_files import GrowingFiles
from seamark.worker.service.live_data import LiveData

PART_EVERY_S = 2.0
PART_MAX = 8 * 2**20  # [B] that are read at once
RETRY_S = 1.0
_log = structlog.get_logger()


class ProgramGone(Exception):
    """The storage is there, but the program is not in it."""


def program_file(settings: Settings, sha256: str) -> Path:
    """Return the file of a program.

    Raises
    ------
    StorageFailed
        The storage is away.
    ProgramGone
    """
    try:
        file = store.path(settings, sha256)
        if not file.is_file():
            storage.require_readable(settings)
    except StorageUnavailable as away:
        raise StorageFailed(str(away)) from away
    if not file.is_file():  # now, too: the storage may have come back in between
        raise ProgramGone(f"the program {sha256} is not in the storage")
    return file


def require_own(session: Session, settings: Settings) -> None:
    """Raise StorageFailed if files now go to the storage of another service."""
    try:
        is_own = data_folder.is_own(session, settings)
    except WrongDataFolder as error:
        raise StorageFailed(str(error)) from error
    if not is_own:
        raise StorageFailed("this is the storage of another service")


class RunUpload:
    """The upload of one attempt, in a thread of its own; who watches it is served before."""

    def __init__(self, objects: Objects, redis: "Redis", files: RunFiles, run_id: int) -> None:
        self._objects, self._files, self._run_id = objects, files, run_id
        self._growing = GrowingFiles(files)
        self._live = LiveData(redis, self._growing, run_id)
        self._replaced: dict[str, float] = {}  # file -> when it was written last
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._store_parts, name="upload", daemon=True)

    def start(self) -> None:
        """Remove what earlier attempts have stored, and store parts from now on."""
        self._thread.start()
        self._live.start()

    def truncate_rows(self, count: int) -> None:
        """Keep only the first rows of the telemetry; see `RunFiles.truncate_rows`."""
        self._growing.truncate_rows(count)

    def stop(self) -> None:
        """Store no more parts, and publish no more."""
        self._live.stop()
        self._ending.set()
        if self._thread.ident is not None:
            self._thread.join()

    def complete(self, watch: Callable[[], None], *, within_s: float) -> None:
        """Store all files as they are now, and say that this is all.

        Parameters
        ----------
        watch
            Called while this takes; what it raises ends the waiting.
        within_s
            How long the storage may be away.

        Raises
        ------
        StorageFailed
            It was away for longer, or the files cannot be read.
        """
        self._ending.set()
        done, given_up = threading.Event(), threading.Event()
        failures: list[Exception] = []

        def store() -> None:
            try:
                self.stop()
                self._store_whole_within(within_s, given_up)
            except Exception as error:
                failures.append(error)
            finally:  # whatever happened: the run waits for it
                done.set()

        threading.Thread(target=store, name="upload-end", daemon=True).start()
        try:
            while not done.wait(0.1):
                watch()
        finally:
            given_up.set()
        if failures:
            raise StorageFailed(str(failures[0])) from failures[0]

    def remove_parts(self) -> None:
        """Remove the parts, which whole files have replaced."""
        self._quietly(
            lambda: self._objects.delete(
                [one.path for one in self._objects.list(f"{self._folder}/parts")]
            )
        )

    def remove(self) -> None:
        """Remove everything that this attempt has stored."""
        self._quietly(lambda: run_objects.remove(self._objects, self._run_id, self._files.attempt))

    @property
    def _folder(self) -> str:
        return run_objects.folder(self._run_id, self._files.attempt)

    def _store_parts(self) -> None:
        self._quietly(
            lambda: run_objects.remove_before(self._objects, self._run_id, self._files.attempt)
        )
        away = False
        while not self._ending.wait(PART_EVERY_S):
            try:
                self._growing.begin_parts()
                for name in REPLACED:
                    self._store_replaced(name)
                for name in GROWING:
                    self._store_grown(name)
                away = False
            except ObjectsAway as error:
                if not away:
                    _log.warning("objects_away", run=self._run_id, error=str(error))
                away = True

    def _store_replaced(self, name: str) -> None:
        file = self._files.folder / name
        try:
            written_at = file.stat().st_mtime
        except FileNotFoundError:
            return
        if self._replaced.get(name) != written_at:
            self._objects.put(f"{self._folder}/{name}", file.read_bytes())
            self._replaced[name] = written_at

    def _store_grown(self, name: str) -> None:
        while (piece := self._growing.unstored(name, limit=PART_MAX)).content:
            path = run_objects.part(
                self._run_id,
                self._files.attempt,
                name,
                generation=piece.generation,
                offset=piece.offset,
            )
            self._objects.put(path, piece.content)
            self._growing.stored(piece)

    def _store_whole_within(self, seconds: float, given_up: threading.Event) -> None:
        until = time.monotonic() + seconds
        while not given_up.is_set():
            try:
                return self._store_whole()
            except ObjectsAway:
                if time.monotonic() + RETRY_S >= until:
                    raise
                given_up.wait(RETRY_S)

    def _store_whole(self) -> None:
        folder = self._files.folder  # none: the run ended before it recorded anything
        names = sorted(file.name for file in folder.iterdir()) if folder.is_dir() else []
        for name in names:
            self._objects.put(f"{self._folder}/{name}", self._files.folder / name)
        self._objects.put(f"{self._folder}/{COMPLETE}", json.dumps(names).encode())

    def _quietly(self, action: Callable[[], None]) -> None:
        """Do what a later sweep does if it fails now."""
        try:
            action()
        except ObjectsAway as error:
            _log.warning("objects_not_removed", run=self._run_id, error=str(error))
