"""Who may be on which core, as two processes of one worker see it."""

import os
from collections.abc import Callable, Iterator
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

import pytest

from seamark.worker.evaluation.cores import Cores, new_locks

SHARE = (0, 1)
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
    """Another process of the same worker, at home on core 1; None ends it."""
    context = get_context("fork")
    mine, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(Cores(1, SHARE, locks=locks), theirs))
    process.start()

    def ask(name: str | None, *values: int) -> Any:
        mine.send(None if name is None else (name, *values))
        return process.join(10) if name is None else mine.recv()

    yield ask
    if process.is_alive():
        ask(None)


def test_an_empty_core_is_borrowed_after_ones_own(locks: int) -> None:
    cores = Cores(0, SHARE, locks=locks)
    cores.move_in()

    assert [cores.take(), cores.take(), cores.take()] == [0, 1, None]
    cores.give_back(1)
    assert cores.take() == 1


def test_nobody_visits_where_a_run_is_at_home(locks: int, neighbour: Ask) -> None:
    cores = Cores(0, SHARE, locks=locks)
    neighbour("move_in")

    assert [cores.take(), cores.take()] == [0, None]


def test_who_comes_home_waits_for_no_guest_and_the_guest_does_not_come_again(
    locks: int, neighbour: Ask
) -> None:
    cores = Cores(0, SHARE, locks=locks)
    cores.take()
    assert cores.take() == 1

    neighbour("move_in")

    assert neighbour("take") == 1
    cores.give_back(1)
    assert cores.take() is None


def test_a_core_has_one_guest_at_a_time(locks: int, neighbour: Ask) -> None:
    cores = Cores(2, (0, 1, 2), locks=locks)  # the neighbour may be on 0 and 1 alone

    assert [cores.take(), cores.take()] == [2, 0]
    assert [neighbour("take"), neighbour("take")] == [1, None]
    neighbour("give_back", 1)
    assert cores.take() == 1


def test_a_process_that_dies_frees_its_cores(locks: int, neighbour: Ask) -> None:
    cores = Cores(0, SHARE, locks=locks)
    neighbour("move_in")
    cores.take()
    assert cores.take() is None

    neighbour(None)

    assert cores.take() == 1


def test_without_a_neighbour_all_cores_are_free() -> None:
    cores = Cores(None, SHARE)

    assert [cores.take(), cores.take(), cores.take()] == [0, 1, None]
    assert cores.count == 2
