"""Places that owners share: one each at a time, and in turns while others wait."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

ALL_WAITING_MAX = 12  # threads of all owners: whoever has many owners shall not take all threads


class PlacesBusy(Exception):
    """There was no place in time, or too many wait already: of the owner, or of all."""


class FairPlaces:
    """A number of places; whoever waits longest among the owners without one gets the next.

    Parameters
    ----------
    count
        Places.
    wait_s
        How long `taken` waits for one.
    waiting_max
        How many threads of one owner may wait: each of them serves nobody else meanwhile.
    """

    def __init__(self, count: int, *, wait_s: float, waiting_max: int) -> None:
        self._count, self._wait_s, self._waiting_max = count, wait_s, waiting_max
        self._changed = threading.Condition()
        self._busy: set[str] = set()
        self._waiting: dict[str, int] = {}  # owner -> threads, in the order of their turns

    @contextmanager
    def taken(self, owner: str) -> Iterator[None]:
        """Hold a place; raises PlacesBusy without one."""
        with self._changed:
            own, everybody = self._waiting.get(owner, 0), sum(self._waiting.values())
            if own >= self._waiting_max or everybody >= ALL_WAITING_MAX:
                raise PlacesBusy
            self._waiting[owner] = own + 1
            got = self._changed.wait_for(lambda: self._is_next(owner), self._wait_s)
            self._leave_queue(owner)
            if not got:
                raise PlacesBusy
            self._busy.add(owner)
            self._changed.notify_all()
        try:
            yield
        finally:
            with self._changed:
                self._busy.remove(owner)
                self._changed.notify_all()

    def _is_next(self, owner: str) -> bool:
        free = len(self._busy) < self._count
        return free and owner == next((o for o in self._waiting if o not in self._busy), None)

    def _leave_queue(self, owner: str) -> None:
        left = self._waiting.pop(owner) - 1
        if left:
            self._waiting[owner] = left  # behind the owners that wait now
