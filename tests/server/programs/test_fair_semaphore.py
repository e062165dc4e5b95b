"""Slots shared between owners: nobody keeps them from the others."""

import string
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

import pytest

from seamark.server.programs.fair_semaphore import ALL_WAITING_MAX, FairSemaphore, SlotsBusy

LONG_S = 60.0  # until a thread has been scheduled on a busy machine


class Uploads:
    """Uploads in threads: each holds its slot until it is told to end."""

    def __init__(self, slots: FairSemaphore) -> None:
        self.slots, self.started = slots, list[str]()
        self._ends: dict[str, threading.Event] = {}
        self._threads = ThreadPoolExecutor(16)

    def begin(self, name: str) -> Future[None]:
        """Begin an upload; its name starts with that of the owner, a letter."""
        self._ends[name] = threading.Event()
        return self._threads.submit(self._hold, name)

    def end(self, name: str) -> None:
        self._ends[name].set()

    def await_start(self, owner: str) -> None:
        _eventually(lambda: self.started[-1][0] == owner)

    def _hold(self, name: str) -> None:
        with self.slots.taken(name[0]):
            self.started.append(name)
            assert self._ends[name].wait(LONG_S)


def _eventually(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + LONG_S
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def _waits(slots: FairSemaphore, owner: str, threads: int) -> Callable[[], bool]:
    return lambda: slots._waiting.get(owner, 0) == threads


def test_an_owner_has_one_place_and_the_next_goes_to_whoever_waits_longest() -> None:
    slots = FairSemaphore(2, wait_s=LONG_S, waiting_max=3, what="uploads")
    uploads = Uploads(slots)
    uploads.begin("a1")
    _eventually(lambda: uploads.started == ["a1"])
    for name, threads in (("a2", 1), ("a3", 2)):
        uploads.begin(name)
        _eventually(_waits(slots, "a", threads))
    uploads.begin("b1")
    _eventually(lambda: uploads.started == ["a1", "b1"])
    uploads.begin("c1")
    _eventually(_waits(slots, "c", 1))

    uploads.end("b1")
    _eventually(lambda: uploads.started == ["a1", "b1", "c1"])
    uploads.begin("b2")
    _eventually(_waits(slots, "b", 1))
    for at, following in ((0, "a"), (2, "b"), (3, "a")):
        uploads.end(uploads.started[at])
        uploads.await_start(following)
    for name in uploads.started:
        uploads.end(name)

    assert [name[0] for name in uploads.started] == ["a", "b", "c", "a", "b", "a"]


def test_an_owner_does_not_wait_with_more_threads_than_allowed() -> None:
    slots = FairSemaphore(1, wait_s=LONG_S, waiting_max=1, what="uploads")
    uploads = Uploads(slots)
    uploads.begin("a1")
    _eventually(lambda: uploads.started == ["a1"])
    waiting = uploads.begin("a2")
    _eventually(_waits(slots, "a", 1))

    with pytest.raises(SlotsBusy, match="1 uploads of yours wait already") as busy:
        uploads.begin("a3").result(LONG_S)
    assert busy.value.own

    uploads.end("a1")
    uploads.end("a2")
    waiting.result(LONG_S)


def test_many_owners_leave_threads_for_the_pages() -> None:
    slots = FairSemaphore(1, wait_s=LONG_S, waiting_max=2, what="uploads")
    uploads = Uploads(slots)
    uploads.begin("A1")
    _eventually(lambda: uploads.started == ["A1"])
    owners = string.ascii_lowercase[:ALL_WAITING_MAX]
    for owner in owners:
        uploads.begin(f"{owner}1")
        _eventually(_waits(slots, owner, 1))

    with pytest.raises(SlotsBusy, match=f"{ALL_WAITING_MAX} uploads wait already") as busy:
        uploads.begin("z1").result(LONG_S)
    assert busy.value.retry_after_s == ALL_WAITING_MAX + 1

    for name in ("A1", *(f"{owner}1" for owner in owners)):
        uploads.end(name)


def test_without_a_place_in_time_an_upload_is_refused_and_waits_no_longer() -> None:
    slots = FairSemaphore(1, wait_s=0.01, waiting_max=3, what="uploads")
    uploads = Uploads(slots)
    uploads.begin("a1")
    _eventually(lambda: uploads.started == ["a1"])

    with pytest.raises(SlotsBusy):
        uploads.begin("b1").result(LONG_S)

    assert _waits(slots, "b", 0)()
    uploads.end("a1")


def test_an_owner_is_told_to_wait_for_the_turns_of_the_others_too() -> None:
    slots = FairSemaphore(1, wait_s=LONG_S, waiting_max=1, what="uploads")
    uploads = Uploads(slots)
    uploads.begin("a1")
    _eventually(lambda: uploads.started == ["a1"])
    for owner in "abc":
        uploads.begin(f"{owner}2")
        _eventually(_waits(slots, owner, 1))

    with pytest.raises(SlotsBusy) as busy:
        uploads.begin("a3").result(LONG_S)

    assert busy.value.retry_after_s == 2 * 3  # two turns of three owners, of a second each
    for name in ("a1", "a2", "b2", "c2"):
        uploads.end(name)
