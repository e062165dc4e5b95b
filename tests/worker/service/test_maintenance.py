"""The periodic tasks of the maintenance process."""

import threading

import pytest

from seamark.server.messaging import broker
from seamark.server.messaging.shared_meters import SharedMeters
from seamark.server.settings import Settings
from seamark.worker.service.maintenance import (
    PeriodicTask,
    by_rights,
    maintain,
    next_due_in_s,
    run_due,
)

PATIENCE_S = 60.0


def test_a_periodic_task_that_fails_stops_neither_the_others_nor_its_next_time() -> None:
    done: list[str] = []

    def fail() -> None:
        done.append("fails")
        raise FileNotFoundError("deleted by another worker")

    tasks = [
        PeriodicTask("fails", 0.0, fail),
        PeriodicTask("works", 0.0, lambda: done.append("works")),
    ]
    run_due(tasks, on_duty=lambda: True)
    run_due(tasks, on_duty=lambda: True)

    assert done == ["fails", "works"] * 2


@pytest.mark.parametrize(("period_s", "times"), [(0.0, 3), (3600.0, 0)])
def test_a_periodic_task_runs_once_per_period(period_s: float, times: int) -> None:
    done: list[str] = []
    task = PeriodicTask("count", period_s, lambda: done.append("once"))

    for _ in range(3):
        run_due([task], on_duty=lambda: True)

    assert len(done) == times


def test_who_is_not_on_duty_leaves_what_is_due_to_others_and_asks_once_per_period() -> None:
    done: list[str] = []
    asked: list[str] = []
    task = PeriodicTask("count", 3600.0, lambda: done.append("once"))
    task.due_at = 0.0

    def on_duty() -> bool:
        asked.append("asked")
        return False

    for _ in range(3):
        run_due([task], on_duty=on_duty)

    assert done == []
    assert asked == ["asked"]


@pytest.mark.parametrize(
    ("all_rights", "key", "expected"),
    [
        (
            True,
            True,
            {"": ["plain"], "all": ["delete_accounts"], "seeds": ["fill_seeds", "verify_first"]},
        ),
        (False, False, {"": ["plain"], "all": [], "seeds": []}),
        (False, True, {"": ["plain"], "all": [], "seeds": ["fill_seeds"]}),
        (True, False, {"": ["plain"], "all": ["delete_accounts"], "seeds": []}),
    ],
)
def test_a_task_is_left_to_processes_that_have_what_it_needs(
    all_rights: bool, key: bool, expected: dict[str, list[str]]
) -> None:
    names = ("plain", "recover_runs", "delete_accounts", "fill_seeds", "verify_first")
    tasks = [PeriodicTask(name, 1.0, lambda: None) for name in names]

    found = by_rights(tasks, all_rights=all_rights, key=key)

    wanted = expected | {"recovery": ["recover_runs"]}
    assert {rights: [task.name for task in those] for rights, those in found.items()} == wanted


@pytest.mark.parametrize("on_duty", [True, False])
def test_nothing_is_looked_at_before_the_next_task_is_due(on_duty: bool) -> None:
    tasks = [
        PeriodicTask(name, period_s, lambda: None) for name, period_s in (("a", 50), ("b", 70))
    ]

    assert 40.0 < next_due_in_s(tasks) <= 50.0
    tasks[0].due_at = 0.0
    assert next_due_in_s(tasks) == 0.0
    run_due(tasks, on_duty=lambda: on_duty)
    assert 40.0 < next_due_in_s(tasks) <= 50.0


def test_a_storage_that_hangs_holds_up_no_recovery(settings: Settings) -> None:
    stopping, hangs, recovered = threading.Event(), threading.Event(), threading.Semaphore(0)

    def hang() -> None:
        hangs.wait(PATIENCE_S)

    tasks = [
        PeriodicTask("recover_runs", 0.05, recovered.release),
        PeriodicTask("sweep_data", 0.0, hang),
    ]
    duties = by_rights(tasks, all_rights=False, key=False)
    redis = broker.connect(settings)
    process = threading.Thread(
        target=maintain,
        args=(duties, redis, redis, stopping, SharedMeters(redis)),
        kwargs={"kept_s": 30.0},
    )

    process.start()
    looks = [recovered.acquire(timeout=PATIENCE_S / 2) for _ in range(5)]
    stopping.set()
    hangs.set()
    process.join()
    redis.close()

    assert looks == [True] * 5
