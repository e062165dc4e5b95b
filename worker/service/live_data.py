"""Publishes what a run records while somebody watches it, before it is stored.

Nothing here stops a run, nor does it wait for the broker: what is not published is in the parts
that the storage has a few seconds later.
"""

import threading
import time

import structlog
from redis import Redis
from redis.exceptions import RedisError

from seamark.server.messaging import live_data
from seamark.server.messaging.live_data import Increment, Piece
from seamark.server.runs.data.run_objects import GROWING, REPLACED
from seamark.worker.service.growing_files import GrowingFiles

TICK_S = 0.1  # between two messages
LOOK_S = 0.5  # between two looks at whether somebody watches
SILENT_S = 0.5  # after which an empty message says that nothing was missed
MESSAGE_MAX = 2**20  # [B] of each file in a message: faster runs wait for their stored parts
TAIL_MAX = 16 * 1024  # [B] of the end of a long log; 8 bytes before it say where it begins
STOP_S = 1.0  # that the end of a run waits for a broker
_OFFSET_BYTES = 8
_log = structlog.get_logger()


class LiveData:
    """The publication of one attempt, in a thread of its own."""

    def __init__(self, redis: "Redis", growing: GrowingFiles, run_id: int) -> None:
        self._redis, self._growing, self._run_id = redis, growing, run_id
        self._last = dict[str, Piece]()  # that was published of a file
        self._written_at = dict[str, float]()  # of the published whole files
        self._mark: bytes | None = None
        self._published_at = 0.0  # monotonic
        self._failing = False
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._follow, name="live-data", daemon=True)

    def start(self) -> None:
        """Publish from now on."""
        self._thread.start()

    def stop(self) -> None:
        """Publish what is left, and then no more."""
        self._ending.set()
        if self._thread.ident is not None:
            self._thread.join(STOP_S)

    def _follow(self) -> None:
        ending = False
        while not ending:
            ending = self._ending.wait(LOOK_S if self._mark is None else TICK_S)
            try:
                self._look()
                self._failing = False
            except RedisError as error:
                if not self._failing:
                    _log.warning("data_not_published", run=self._run_id, error=str(error))
                self._failing, self._mark = True, None

    def _look(self) -> None:
        mark = live_data.mark(self._redis, self._run_id)
        if mark != self._mark:  # somebody begins to watch, or has missed something
            self._mark = mark
            self._last.clear()
            self._written_at.clear()
        if mark is not None:
            self._publish()

    def _publish(self) -> None:
        following = self._growing.following
        pieces = [following(name, self._last.get(name), limit=MESSAGE_MAX) for name in GROWING]
        whole = self._replaced()
        now = time.monotonic()
        if not (any(piece.content for piece in pieces) or whole) and (
            now < self._published_at + SILENT_S
        ):
            return
        attempt = self._growing.files.attempt
        live_data.publish(self._redis, self._run_id, Increment(attempt, pieces, whole))
        self._published_at = now
        self._last = {piece.file: piece for piece in pieces}

    def _replaced(self) -> dict[str, bytes]:
        """Return the files that were replaced since the last time."""
        contents = {}
        for name in REPLACED:
            file = self._growing.files.folder / name
            try:
                written_at = file.stat().st_mtime
                if self._written_at.get(name) != written_at:
                    content = file.read_bytes()
                    contents[name] = _end(content) if name == "log.tail" else content
                    self._written_at[name] = written_at
            except FileNotFoundError:
                continue
        return contents


def _end(tail: bytes) -> bytes:
    """Return a shorter `log.tail` with the same end."""
    start, text = int.from_bytes(tail[:_OFFSET_BYTES], "little"), tail[_OFFSET_BYTES:]
    kept = text[-TAIL_MAX:]
    return (start + len(text) - len(kept)).to_bytes(_OFFSET_BYTES, "little") + kept
