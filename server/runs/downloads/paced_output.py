"""An output that gives up a reader who takes too long: it would hold a place for ever."""

import signal
import time
from typing import Any, BinaryIO

PATIENCE_S = 60.0  # for a reader who takes nothing, and
PACE_BYTES_S = 50_000.0  # this much longer for what it has taken


class PacedOutput:
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
