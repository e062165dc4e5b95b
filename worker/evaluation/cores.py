"""Which cores a run may use: always its own, and the worker's others while they are idle.

Every process of the worker's pool owns one core. A run of several trials borrows the cores of idle
processes, for one trial at a time; so a run that starts on a borrowed core shares it for the rest
of one trial at most.

Occupied and borrowed cores, those with a warm simulator, and the parts of the simulator that a
process has loaded are record locks on an anonymous file that all processes of a worker have open:
the kernel drops them with the process that holds them, and a fork does not inherit them.
"""

import fcntl
import os
from collections.abc import Sequence

NO_LOCKS = -1  # no other process uses these cores
_PARTS_AT = 1 << 20  # byte of the first part; those of cores are below


def new_locks() -> int:
    """Return the descriptor of one worker's lock file."""
    return os.memfd_create("seamark-cores", os.MFD_CLOEXEC)


class Cores:
    """The cores of one run. Belongs to one process; its forks must not use it."""

    def __init__(self, own: int | None, shared: Sequence[int], *, locks: int = NO_LOCKS) -> None:
        """With `own` None all shared cores are alike."""
        others = [core for core in shared if core != own]
        self._own = own
        self._order = others if own is None else [own, *others]
        self._locks = locks
        self._acquired: set[int] = set()

    @property
    def count(self) -> int:
        """How many trials can run in parallel at most."""
        return len(self._order)

    def occupy(self) -> None:
        """Keep others from borrowing this process's own core, until the process ends.

        Returns at once, even if the core is borrowed at the moment.
        """
        if self._locks != NO_LOCKS and self._own is not None:
            fcntl.lockf(self._locks, fcntl.LOCK_SH, 1, _occupied_byte(self._own))

    def announce_warm(self) -> None:
        """Let `any_warm` know that this process's core has a warm simulator, until it ends."""
        if self._locks != NO_LOCKS and self._own is not None:
            fcntl.lockf(self._locks, fcntl.LOCK_SH, 1, _warm_byte(self._own))

    def any_warm(self) -> bool:
        """Return whether another process has announced a warm simulator for one of the cores."""
        return not all(self._is_free(_warm_byte(core)) for core in self._order)

    def announce_part(self, index: int, of: int) -> None:
        """Let `parts` know that this process has loaded a part of the simulator, until it ends."""
        if self._locks != NO_LOCKS:
            os.pwrite(self._locks, bytes([of]), 0)
            fcntl.lockf(self._locks, fcntl.LOCK_SH, 1, _PARTS_AT + index)

    def parts(self) -> tuple[int, int]:
        """Return how many parts of the simulator other processes have loaded, and of how many.

        Of 0 parts until one is loaded.
        """
        of = sum(os.pread(self._locks, 1, 0))
        return sum(not self._is_free(_PARTS_AT + index) for index in range(of)), of

    def acquire(self) -> int | None:
        """Return a core that is free now, its own one first; None if there is none."""
        for core in self._order:
            if core not in self._acquired and (core == self._own or self._borrow(core)):
                self._acquired.add(core)
                return core
        return None

    def release(self, core: int) -> None:
        """Free an acquired core."""
        self._acquired.discard(core)
        if self._locks != NO_LOCKS and core != self._own:
            fcntl.lockf(self._locks, fcntl.LOCK_UN, 1, _borrowed_byte(core))

    def _borrow(self, core: int) -> bool:
        """Become the only borrower of a core that nobody occupies; False if that is impossible."""
        if self._locks == NO_LOCKS:
            return True
        if not self._lock(_borrowed_byte(core)):
            return False
        idle = self._lock(_occupied_byte(core))
        byte = _occupied_byte(core) if idle else _borrowed_byte(core)
        fcntl.lockf(self._locks, fcntl.LOCK_UN, 1, byte)
        return idle

    def _is_free(self, byte: int) -> bool:
        if not self._lock(byte):
            return False
        fcntl.lockf(self._locks, fcntl.LOCK_UN, 1, byte)
        return True

    def _lock(self, byte: int) -> bool:
        try:
            fcntl.lockf(self._locks, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, byte)
        except (BlockingIOError, PermissionError):  # EAGAIN or EACCES, fcntl(2)
            return False
        return True


def _occupied_byte(core: int) -> int:
    return 3 * core


def _borrowed_byte(core: int) -> int:
    return 3 * core + 1


def _warm_byte(core: int) -> int:
    return 3 * core + 2
