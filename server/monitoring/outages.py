"""Tells in the log that a part of the service is away, without filling the disk with it.

Whoever asks in vain every second says so once, then once a minute, and when the part is back.
"""

import threading
import time

import structlog

EVERY_S = 60.0  # between two lines while a part is away
WHY_MAX = 300  # [character] of what a library says
_log = structlog.get_logger()


class Outage:
    """What one process, or one of its tasks, has seen of a part that it needs.

    Parameters
    ----------
    part
        As events call it: `<part>_away`, `<part>_back`.
    every_s
        Time between two lines.
    **ids
        Go into each line.
    """

    def __init__(self, part: str, *, every_s: float = EVERY_S, **ids: object) -> None:
        self._part, self._every_s, self._ids = part, every_s, ids
        self._lock = threading.Lock()
        self._failures = 0
        self._since = self._said_at = 0.0  # monotonic

    def failed(self, error: Exception) -> None:
        """Note that the part could not be reached."""
        with self._lock:
            now = time.monotonic()
            self._failures += 1
            if self._failures == 1:
                self._since = now
            elif now - self._said_at < self._every_s:
                return
            self._said_at = now
            ids = self._ids | self._known(now)
        _log.warning(f"{self._part}_away", why=_first_line(error), **ids)

    def over(self) -> None:
        """Note that the part was reached."""
        if not self._failures:  # the usual case needs no lock
            return
        with self._lock:
            ids = self._ids | self._known(time.monotonic())
            failures, self._failures = self._failures, 0
        if failures:
            _log.info(f"{self._part}_back", **ids)

    def _known(self, now: float) -> dict[str, object]:
        return {"failures": self._failures, "for_s": round(now - self._since, 1)}


def _first_line(error: Exception) -> str:
    text = str(error).partition("\n")[0]
    return f"{type(error).__name__}: {text}"[:WHY_MAX]
