"""Which core a run may use, as seen by two processes of one worker."""

import os
from collections.abc import Callable, Iterator
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

import pytest

from seamark.worker.evaluation.cores import Cores, new_locks

SHARED = (0, 1)
Ask = Callable[..., Any]


def _serve(cores: Cores, questions: Connection) -> None:
    while (question := questions.recv()) is not None:
        name, *values = question
        questions.send(getattr(cores, name)(*values))


@pytest.fixture
def locks() -> Iterator[int]:
    descriptor = new_locks()
    yield descriptor
    os.close(descriptor)


@pytest.fixture
def neighbour(locks: int) -> Iterator[Ask]:
    """Another process of the same worker, which owns core 1; None ends it."""
    context = get_context("fork")
    mine, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(Cores(1, SHARED, locks=locks), theirs))
    process.start()

    def ask(name: str | None, *values: int) -> Any:
        mine.send(None if name is None else (name, *values))
        return process.join(10) if name is None else mine.recv()

    yield ask
    if process.is_alive():
        ask(None)


def test_an_idle_core_is_borrowed_after_the_own_one(locks: int) -> None:
    cores = Cores(0, SHARED, locks=locks)
    cores.occupy()

    assert [cores.acquire(), cores.acquire(), cores.acquire()] == [0, 1, None]
    cores.release(1)
    assert cores.acquire() == 1


def test_an_occupied_core_is_not_borrowed(locks: int, neighbour: Ask) -> None:
    cores = Cores(0, SHARED, locks=locks)
    neighbour("occupy")

    assert [cores.acquire(), cores.acquire()] == [0, None]


def test_a_borrowed_core_can_be_occupied_at_once_and_is_not_borrowed_again(
    locks: int, neighbour: Ask
) -> None:
    cores = Cores(0, SHARED, locks=locks)
    cores.acquire()
    assert cores.acquire() == 1

    neighbour("occupy")

    assert neighbour("acquire") == 1
    cores.release(1)
    assert cores.acquire() is None


def test_a_core_has_one_borrower_at_a_time(locks: int, neighbour: Ask) -> None:
    cores = Cores(2, (0, 1, 2), locks=locks)  # the neighbour may use 0 and 1 only

    assert [cores.acquire(), cores.acquire()] == [2, 0]
    assert [neighbour("acquire"), neighbour("acquire")] == [1, None]
    neighbour("release", 1)
    assert cores.acquire() == 1


def test_a_process_that_dies_frees_its_cores(locks: int, neighbour: Ask) -> None:
    cores = Cores(0, SHARED, locks=locks)
    neighbour("occupy")
    cores.acquire()
    assert cores.acquire() is None

    neighbour(None)

    assert cores.acquire() == 1


def test_without_a_neighbour_all_cores_are_free() -> None:
    cores = Cores(None, SHARED)

    assert [cores.acquire(), cores.acquire(), cores.acquire()] == [0, 1, None]
    assert cores.count == 2


def test_a_warm_simulator_is_known_until_its_process_ends(locks: int, neighbour: Ask) -> None:
    cores = Cores(0, SHARED, locks=locks)
    before = cores.any_warm()

    neighbour("announce_warm")
    during = cores.any_warm()
    borrowed = cores.acquire(), cores.acquire()
    neighbour(None)

    assert (before, during, cores.any_warm()) == (False, True, False)
    assert borrowed == (0, 1)  # a warm simulator does not occupy its core
