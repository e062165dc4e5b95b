"""What a session of a connected program may take of a web process."""

import pytest

from seamark.server.web.streams.bridge_session import MESSAGE_COST, Budget


class Clock:
    """A clock that a test moves."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def _passed_s(budget: Budget, clock: Clock, messages: int, size: int) -> float:
    """Return the time that messages take which come as fast as they may."""
    began = clock.now
    for _ in range(messages):
        clock.now += budget.delay_s(size)
    return clock.now - began


@pytest.mark.parametrize(("size", "counted"), [(10_000, 10_000), (1, MESSAGE_COST)])
def test_messages_pass_at_the_rate_after_a_burst_of_a_second(size: int, counted: int) -> None:
    clock = Clock()
    budget = Budget(1_000_000, clock)

    assert _passed_s(budget, clock, 1_000_000 // counted, size) == 0.0
    assert _passed_s(budget, clock, 3_000_000 // counted, size) == pytest.approx(3.0, rel=1e-2)


def test_a_program_that_rests_saves_no_more_than_a_second() -> None:
    clock = Clock()
    budget = Budget(1_000_000, clock)
    clock.now += 3600.0

    assert _passed_s(budget, clock, 100, 10_000) == 0.0
    assert budget.delay_s(10_000) == pytest.approx(0.01)
