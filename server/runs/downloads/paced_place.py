"""A place for downloads that are made while they are sent; who takes one too slowly loses it.

Otherwise a single reader of a few bytes a minute would keep everybody else waiting.
"""

import threading
import time
from collections.abc import Callable, Generator

from seamark.server.runs.downloads.paced_output import PACE_BYTES_S, PATIENCE_S


class PlaceTaken(Exception):
    """Another download has the place; try again."""


class ReaderTooSlow(Exception):
    """The place was given to somebody else while the reader took nothing."""


class PacedPlace:
    """One place; `clock` [s] tells how long a reader has kept its download waiting."""

    def __init__(self, *, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._download: Download | None = None

    def take(self) -> "Download":
        """Return a download without pieces, which has the place; raises PlaceTaken."""
        with self._lock:
            if self._download is not None:
                if not self._download.is_too_slow():
                    raise PlaceTaken
                self._download.lose()
            self._download = Download(self._lock, self._clock, self._give_back)
            return self._download

    def _give_back(self, download: "Download") -> None:
        with self._lock:
            if self._download is download:
                self._download = None


class Download:
    """The pieces of one file; `close` gives the place back, whether it was read or not.

    Its pieces are made in one thread at a time, while the place may be taken in others.
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
        """Stop, and give the place back."""
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
