"""A process of the pool whose simulator is still starting, for instance after it was replaced."""

from collections.abc import Iterator
from contextlib import closing, contextmanager

import pytest
from celery import Celery
from redis import Redis

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.server.messaging import broker
from seamark.server.runs.record.states import RunState
from seamark.worker.service.host import Host
from seamark.worker.service.run_loop import RunLoop
from tests.cast import Backend


class StartingSimulator:
    """A simulator that is warm when it was asked often enough."""

    def __init__(self, polls: int) -> None:
        self.polls_left = polls

    def start(self) -> None: ...

    def stop(self) -> None: ...

    def wait_warm(self, timeout_s: float) -> bool:
        self.polls_left -= 1
        return self.polls_left < 0


@pytest.fixture
def redis(redis_url: str) -> Iterator[Redis]:
    with Redis.from_url(redis_url) as client:
        yield client


def _tickets(redis: Redis, app: Celery) -> int:
    return sum(int(redis.llen(key)) for key in broker.ticket_keys(app))


@contextmanager
def _starting(
    backend: Backend, simulator: StartingSimulator, *, polls_until_shutdown: int = -1
) -> Iterator[tuple[RunLoop, Celery]]:
    app = broker.celery_app(backend.settings)
    loop = RunLoop(
        app,
        backend.settings,
        Host(backend.settings, "w", IsolationLevel.NONE, (), ()),
        index=0,
        shutting_down=lambda: simulator.polls_left == polls_until_shutdown,
        simulator=simulator,  # type: ignore[arg-type]
    )
    with closing(loop):
        yield loop, app
    app.close()


@pytest.mark.timeout(60)
def test_a_process_that_is_not_ready_leaves_its_ticket_to_one_that_is(
    backend: Backend, redis: Redis
) -> None:
    run_id = backend.queue("ann")

    with _starting(backend, StartingSimulator(9), polls_until_shutdown=5) as (loop, app):
        before = _tickets(redis, app)
        loop.run_next()
        after = _tickets(redis, app)

    assert backend.show(run_id).state is RunState.QUEUED
    assert after == before + 1


@pytest.mark.timeout(60)
def test_waiting_for_a_simulator_that_is_being_compiled_takes_one_ticket(
    backend: Backend, redis: Redis
) -> None:
    simulator = StartingSimulator(50)

    with _starting(backend, simulator) as (loop, app):
        before = _tickets(redis, app)
        loop.run_next()  # returns when the simulator is warm, and no run waits
        after = _tickets(redis, app)

    assert simulator.polls_left < 0
    assert after == before + 1
