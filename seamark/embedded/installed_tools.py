"""Notices that programs were installed on this machine, for instance another compiler.

A worker finds out at its start what it can run, so it has to look again then.
"""

import time
from pathlib import Path

# What every installation changes: the package manager's list, and folders of programs.
WATCHED = (
    Path("/var/lib/dpkg/status"),
    Path("/usr/bin"),
    Path("/usr/local/bin"),
)
LOOK_EVERY_S = 10.0  # [s] also how long an installation must have been over

State = tuple[int, ...]


class InstalledTools:
    """Compares the time of the last installation with that of an accepted state, the first."""

    def __init__(self, watched: tuple[Path, ...] = WATCHED, *, every_s: float = LOOK_EVERY_S):
        self._watched = watched
        self._every_s = every_s
        self._accepted = self._last = self._look()
        self._settled = False
        self._look_at = time.monotonic() + every_s

    def changed(self) -> bool:
        """Return whether something was installed since `accept`, and nothing since the last look.

        Looks every `every_s` only; cheap enough to be called several times a second.
        """
        if time.monotonic() >= self._look_at:
            self._look_at = time.monotonic() + self._every_s
            now = self._look()
            self._settled, self._last = now == self._last, now
        return self._settled and self._last != self._accepted

    def accept(self) -> None:
        """Take the last state for the one from which changes count."""
        self._accepted = self._last

    def _look(self) -> State:
        return tuple(path.stat().st_mtime_ns if path.exists() else 0 for path in self._watched)
