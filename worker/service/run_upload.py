"""Between a worker and the object storage: programs come, the files of a run go.

Of a run that goes on parts are stored, at its end the whole files.

Nothing here stops a run: while the storage is away its files wait on the worker's disk. Only at the
end they must get there, before the result is stored.
"""

import json
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import structlog
from redis import Redis

from seamark.server.programs import store
from seamark.server.runs.data import run_objects
from seamark.server.runs.data.files import RunFiles, StorageFailed
from seamark.server.runs.data.run_objects import COMPLETE, GROWING, REPLACED
from seamark.server.settings import Settings
from seamark.server.storage import storage
from seamark.server.storage.objects import MARK, Objects, ObjectsAway
from seamark.server.storage.storage import StorageUnavailable
from seamark.worker.service.growing_files import GrowingFiles
from seamark.worker.service.live_data import LiveData
from seamark.worker.service.watched import watched

PART_EVERY_S = 2.0
PART_MAX = 8 * 2**20  # [B] that are read at once
PAUSE_DOUBLINGS = 3  # while the storage is away: a look every 16 s
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
    except store.ProgramDamaged as damaged:
        raise ProgramGone(f"the program {sha256} is damaged in the storage") from damaged
    except StorageUnavailable as away:
        raise StorageFailed(str(away)) from away
    if not file.is_file():  # now, too: the storage may have come back in between
        raise ProgramGone(f"the program {sha256} is not in the storage")
    return file


def fetched_program(
    settings: Settings, sha256: str, watch: Callable[[], None], *, within_s: float
) -> Path:
    """Return the file of a program of a run that has been claimed.

    Parameters
    ----------
    watch
        Called while this takes; what it raises ends the waiting.
    within_s
        How long the storage may be away.

    Raises
    ------
    StorageFailed
        It was away for longer.
    ProgramGone
    """
    until = time.monotonic() + within_s
    while True:
        try:
            return watched(partial(program_file, settings, sha256), watch)
        except StorageFailed:
            if time.monotonic() + RETRY_S >= until:
                raise
        watched(partial(time.sleep, RETRY_S), watch)


class RunUpload:
    """The upload of one attempt, in a thread of its own; who watches it is served before."""

    def __init__(self, objects: Objects, redis: "Redis", files: RunFiles, run_id: int) -> None:
        self._objects, self._files, self._run_id = objects, files, run_id
        self._growing = GrowingFiles(files)
        self._live = LiveData(redis, self._growing, run_id)
        self._replaced: dict[str, float] = {}  # file -> when it was written last
        self._whole = set[str]()  # files that are stored as they are at the end
        self._in_touch_at = time.monotonic()  # when last everything was stored, or a piece of it
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._store_parts, name="upload", daemon=True)

    def start(self) -> None:
        """Remove what earlier attempts have stored, and store parts from now on."""
        self._thread.start()
        self._live.start()

    def truncate_rows(self, count: int) -> None:
        """Keep only the first rows of the telemetry; see `RunFiles.truncate_rows`."""
        self._growing.truncate_rows(count)

    @property
    def away_s(self) -> float:
        """How long nothing could be stored although there was something to store [s]."""
        return time.monotonic() - self._in_touch_at

    def stop(self, within_s: float | None = None) -> None:
        """Store no more parts, and publish no more.

        Parameters
        ----------
        within_s
            How long to wait for a part that is being stored; None: until that has ended.
        """
        self._live.stop()
        self._ending.set()
        if self._thread.ident is not None:
            self._thread.join(within_s)

    def complete(
        self, watch: Callable[[], None], *, within_s: float, mark: str | None = None
    ) -> None:
        """Store all files as they are now, and say that this is all.

        Parameters
        ----------
        watch
            Called while this takes; what it raises ends the waiting.
        within_s
            How long the storage may be away, with the time before the end of the run.
        mark
            That of the storage of this service; None: unknown.

        Raises
        ------
        StorageFailed
            It was away for longer, is that of another service, or the files cannot be read.
        """
        self._ending.set()
        given_up = threading.Event()

        def store() -> None:
            try:
                self.stop()
                self._store_whole_within(within_s, given_up, mark)
            except Exception as error:  # whatever it is: the run waits for it
                raise StorageFailed(str(error)) from error

        try:
            watched(store, watch)
        finally:
            given_up.set()

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
        failures = 0  # in a row
        while not self._ending.wait(PART_EVERY_S * 2 ** min(failures, PAUSE_DOUBLINGS)):
            try:
                self._growing.begin_parts()
                for name in REPLACED:
                    self._store_replaced(name)
                for name in GROWING:
                    self._store_grown(name)
                self._in_touch_at = time.monotonic()
                failures = 0
            except ObjectsAway as error:
                if not failures:
                    _log.warning("objects_away", run=self._run_id, error=str(error))
                failures += 1

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
            self._in_touch_at = time.monotonic()

    def _store_whole_within(
        self, seconds: float, given_up: threading.Event, mark: str | None
    ) -> None:
        while not given_up.is_set():
            try:
                self._store_whole()
                return self._require_mark(mark)
            except ObjectsAway:
                if self.away_s + RETRY_S >= seconds:
                    raise
                given_up.wait(RETRY_S)

    def _store_whole(self) -> None:
        folder = self._files.folder  # none: the run ended before it recorded anything
        names = sorted(file.name for file in folder.iterdir()) if folder.is_dir() else []
        for name in names:
            if name not in self._whole:
                self._objects.put(f"{self._folder}/{name}", self._files.folder / name)
                self._whole.add(name)
                self._in_touch_at = time.monotonic()
        self._objects.put(f"{self._folder}/{COMPLETE}", json.dumps(names).encode())

    def _require_mark(self, mark: str | None) -> None:
        """Raise StorageFailed if the files are now in the storage of another service."""
        if mark is not None and (self._objects.get(MARK) or b"").decode().strip() != mark:
            raise StorageFailed("this is the storage of another service")

    def _quietly(self, action: Callable[[], None]) -> None:
        """Do what a later sweep does if it fails now."""
        try:
            action()
        except ObjectsAway as error:
            _log.warning("objects_not_removed", run=self._run_id, error=str(error))
