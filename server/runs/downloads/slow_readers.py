"""Readers of downloads that take too long: they lose their slot or their process.

Otherwise a single reader of a few bytes a minute would keep everybody else waiting.
"""

import signal
import threading
import time
from collections.abc import Callable, Generator
from typing import Any, BinaryIO

PATIENCE_S = 60.0  # for a reader who takes nothing, and
PACE_BYTES_S = 50_000.0  # this much longer for what it has taken


class DeadlineOutput:
    """A file for writing; SIGALRM ends the process if its reader is too slow.

    What counts is the time in which a write waits for the reader, not that in between.
    """

    closed = False

    def __init__(
        self, file: BinaryIO, *, patience_s: float = PATIENCE_S, pace_bytes_s: float = PACE_BYTES_S
    ) -> None:
        self._file = file
        self._patience_s, self._pace_bytes_s = patience_s, pace_bytes_s
        self._waited_s = 0.0
        self._written = 0

    def write(self, data: Any) -> int:
        """Write all of the data."""
        left_s = self._patience_s + self._written / self._pace_bytes_s - self._waited_s
        signal.setitimer(signal.ITIMER_REAL, max(left_s, 1e-3))  # 0 would mean no alarm
        began_at = time.monotonic()
        count = self._file.write(data)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        self._waited_s += time.monotonic() - began_at
        self._written += count
        return count

    def tell(self) -> int:
        """Return how much was written."""
        return self._written

    def flush(self) -> None:
        """Pass on what was written."""
        self._file.flush()

    def close(self) -> None:
        """Do nothing: the process ends."""


class SlotTaken(Exception):
    """Another download has the slot; try again."""


class ReaderTooSlow(Exception):
    """The slot was given to somebody else while the reader took nothing."""


class DownloadSlot:
    """A slot for one download at a time; `clock` [s] measures how long its reader takes nothing."""

    def __init__(self, *, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._download: Download | None = None

    def take(self) -> "Download":
        """Return a download without pieces, which has the slot; raises SlotTaken."""
        with self._lock:
            if self._download is not None:
                if not self._download.is_too_slow():
                    raise SlotTaken
                self._download.lose()
            self._download = Download(self._lock, self._clock, self._give_back)
            return self._download

    def _give_back(self, download: "Download") -> None:
        with self._lock:
            if self._download is download:
                self._download = None


class Download:
    """The pieces of one file; `close` gives the slot back, whether it was read or not.

    Its pieces are made in one thread at a time, while the slot may be taken in others.
    """

    def __init__(
        self,
        lock: threading.Lock,
        clock: Callable[[], float],
        give_back: Callable[["Download"], None],
    ) -> None:
        self._lock, self._clock, self._give_back = lock, clock, give_back
        self._pieces: Generator[bytes, None, None] | None = None
        self._waited_s, self._taken = 0.0, 0  # for the reader; bytes
        self._waits_since: float | None = None  # None while a piece is made
        self._lost = False

    def of(self, pieces: Generator[bytes, None, None]) -> "Download":
        """Set the pieces, and return the download."""
        self._pieces = pieces
        return self

    def __iter__(self) -> "Download":
        """Return itself."""
        return self

    def __next__(self) -> bytes:
        """Return the next piece; raises ReaderTooSlow."""
        with self._lock:
            if self._lost or self._pieces is None:
                raise ReaderTooSlow
            self._waited_s, self._waits_since = self._waiting_s(), None
        try:
            piece = next(self._pieces)
        except BaseException:  # also at the end
            self._give_back(self)
            raise
        with self._lock:
            self._taken, self._waits_since = self._taken + len(piece), self._clock()
        return piece

    def close(self) -> None:
        """Stop, and give the slot back."""
        if self._pieces is not None:
            self._pieces.close()
        self._give_back(self)

    def is_too_slow(self) -> bool:
        """Return whether the reader has kept its download waiting for too long."""
        return self._waiting_s() > PATIENCE_S + self._taken / PACE_BYTES_S

    def lose(self) -> None:
        """Forget the pieces, and what they hold in memory."""
        self._lost = True
        if self._pieces is not None:
            self._pieces.close()
            self._pieces = None

    def _waiting_s(self) -> float:
        since = self._waits_since
        return self._waited_s + (0.0 if since is None else self._clock() - since)
