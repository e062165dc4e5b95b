"""Slots that owners share: one each at a time, and in turns while others wait."""

import math
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

ALL_WAITING_MAX = 12  # threads of all owners: whoever has many owners shall not take all threads
RETRY_MAX_S = 60  # whoever is told more would rather not come again
_FIRST_HELD_S = 1.0  # how long a slot is held, before any was
_NEWEST = 0.2  # weight of the newest slot in the average


class SlotsBusy(Exception):
    """There was no slot in time, or too many wait already. The text is for the user.

    Attributes
    ----------
    retry_after_s : int
        When there will be a slot, by how long slots were held lately [s].
    own : bool
        Those that wait are the owner's own.
    """

    def __init__(self, sentence: str, *, retry_after_s: int, own: bool) -> None:
        super().__init__(f"{sentence} Try again in {retry_after_s} s.")
        self.retry_after_s, self.own = retry_after_s, own


class FairSemaphore:
    """A number of slots; whoever waits longest among the owners without one gets the next.

    Parameters
    ----------
    count
        Slots.
    wait_s
        How long `taken` waits for one.
    waiting_max
        How many threads of one owner may wait: each of them serves nobody else meanwhile.
    what
        What has the slots, in the plural, for the sentence that refuses one more.
    """

    def __init__(self, count: int, *, wait_s: float, waiting_max: int, what: str) -> None:
        self._count, self._wait_s, self._waiting_max = count, wait_s, waiting_max
        self._what, self._held_s = what, _FIRST_HELD_S
        self._changed = threading.Condition()
        self._busy: set[str] = set()
        self._waiting: dict[str, int] = {}  # owner -> threads, in the order of their turns

    @contextmanager
    def taken(self, owner: str) -> Iterator[None]:
        """Hold a slot; raises SlotsBusy without one."""
        with self._changed:
            own, everybody = self._waiting.get(owner, 0), sum(self._waiting.values())
            if own >= self._waiting_max:
                raise self._refused(f"{own} {self._what} of yours wait already.", own, own=True)
            if everybody >= ALL_WAITING_MAX:
                raise self._refused(f"{everybody} {self._what} wait already.", everybody)
            self._waiting[owner] = own + 1
            got = self._changed.wait_for(lambda: self._is_next(owner), self._wait_s)
            self._leave_queue(owner)
            if not got:
                raise self._too_late(owner)
            self._busy.add(owner)
            self._changed.notify_all()
        began = time.monotonic()
        try:
            yield
        finally:
            with self._changed:
                self._held_s += _NEWEST * (time.monotonic() - began - self._held_s)
                self._busy.remove(owner)
                self._changed.notify_all()

    def _too_late(self, owner: str) -> SlotsBusy:
        """Return the refusal of one that has waited for as long as it may."""
        if owner in self._busy:
            sentence = f"One of your {self._what} had your slot for {self._wait_s:g} s."
            return self._refused(sentence, self._waiting.get(owner, 0), own=True)
        sentence = f"Other {self._what} had all slots for {self._wait_s:g} s."
        return self._refused(sentence, sum(self._waiting.values()))

    def _refused(self, sentence: str, waiting: int, *, own: bool = False) -> SlotsBusy:
        """Return the refusal of one more behind those that wait."""
        owners = len({*self._waiting, *self._busy})
        # An owner has one slot at a time, and in turns with the others.
        slots = min(self._count / max(owners, 1), 1.0) if own else self._count
        after_s = math.ceil((waiting + 1) * self._held_s / slots)
        return SlotsBusy(sentence, retry_after_s=min(max(after_s, 1), RETRY_MAX_S), own=own)

    def _is_next(self, owner: str) -> bool:
        free = len(self._busy) < self._count
        return free and owner == next((o for o in self._waiting if o not in self._busy), None)

    def _leave_queue(self, owner: str) -> None:
        left = self._waiting.pop(owner) - 1
        if left:
            self._waiting[owner] = left  # behind the owners that wait now
