"""Which cores a run may use: its own always, the worker's others while no run is at home there.

Every process of the worker's pool has a core of its own, where its runs are at home. A run of
several trials borrows the others for one trial at a time, so a run that comes home shares its core
with a guest for the rest of one trial at most.

What is taken stands in record locks on a file without a name that all processes of a worker have
open: the kernel drops them with the process that holds them, and a fork does not inherit them.
"""

import fcntl
import os
from collections.abc import Sequence

NO_LOCKS = -1  # nobody else is on these cores


def new_locks() -> int:
    """Return the descriptor of the locks of one worker."""
    return os.memfd_create("seamark-cores", os.MFD_CLOEXEC)


class Cores:
    """The cores of one run. Belongs to one process; its forks must not use it."""

    def __init__(self, home: int | None, share: Sequence[int], *, locks: int = NO_LOCKS) -> None:
        """Keep the cores; `home` None means that none is nearer than another."""
        others = [core for core in share if core != home]
        self._home = home
        self._order = others if home is None else [home, *others]
        self._locks = locks
        self._taken: set[int] = set()

    @property
    def count(self) -> int:
        """How many trials can run side by side at most."""
        return len(self._order)

    def move_in(self) -> None:
        """Say that a run is at home here, until this process ends; never waits for a guest."""
        if self._locks != NO_LOCKS and self._home is not None:
            fcntl.lockf(self._locks, fcntl.LOCK_SH, 1, _home_byte(self._home))

    def take(self) -> int | None:
        """Return a core that is free now, the home first; None if there is none."""
        for core in self._order:
            if core not in self._taken and (core == self._home or self._visit(core)):
                self._taken.add(core)
                return core
        return None

    def give_back(self, core: int) -> None:
        """Free a core that was taken."""
        self._taken.discard(core)
        if self._locks != NO_LOCKS and core != self._home:
            fcntl.lockf(self._locks, fcntl.LOCK_UN, 1, _guest_byte(core))

    def _visit(self, core: int) -> bool:
        """Become the one guest of a core where nobody is at home; False if that cannot be."""
        if self._locks == NO_LOCKS:
            return True
        if not self._locked(_guest_byte(core)):
            return False
        empty = self._locked(_home_byte(core))
        byte = _home_byte(core) if empty else _guest_byte(core)
        fcntl.lockf(self._locks, fcntl.LOCK_UN, 1, byte)
        return empty

    def _locked(self, byte: int) -> bool:
        try:
            fcntl.lockf(self._locks, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, byte)
        except (BlockingIOError, PermissionError):  # EAGAIN or EACCES, fcntl(2)
            return False
        return True


def _home_byte(core: int) -> int:
    return 2 * core


def _guest_byte(core: int) -> int:
    return 2 * core + 1
