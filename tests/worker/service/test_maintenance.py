"""The periodic tasks of the maintenance process."""

import pytest

from seamark.worker.service.maintenance import PeriodicTask, run_due


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
