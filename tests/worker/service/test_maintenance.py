"""The duties of the maintenance process."""

import pytest

from seamark.worker.service.maintenance import Duty, do_due


def test_a_duty_that_fails_stops_neither_the_others_nor_its_next_time() -> None:
    done: list[str] = []

    def fail() -> None:
        done.append("fails")
        raise FileNotFoundError("deleted by another worker")

    duties = [Duty("fails", 0.0, fail), Duty("works", 0.0, lambda: done.append("works"))]
    do_due(duties)
    do_due(duties)

    assert done == ["fails", "works"] * 2


@pytest.mark.parametrize(("period_s", "times"), [(0.0, 3), (3600.0, 0)])
def test_a_duty_is_done_once_per_period(period_s: float, times: int) -> None:
    done: list[str] = []
    duty = Duty("count", period_s, lambda: done.append("once"))

    for _ in range(3):
        do_due([duty])

    assert len(done) == times
