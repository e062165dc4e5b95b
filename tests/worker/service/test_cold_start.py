"""A process of the pool whose simulator is still starting, for instance after it was replaced."""

from collections.abc import Iterator
from contextlib import closing

import pytest
from celery import Celery
from redis import Redis

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.server.messaging import broker
from seamark.server.runs.states import RunState
from seamark.worker.service.host import Host
from seamark.worker.service.run_loop import RunLoop
from tests.cast import Backend


class StartingSimulator:
    """A simulator that is not warm yet."""

    def start(self) -> None: ...

    def stop(self) -> None: ...

    def wait_warm(self, timeout_s: float) -> bool:
        return False


@pytest.fixture
def redis(redis_url: str) -> Iterator[Redis]:
    with Redis.from_url(redis_url) as client:
        yield client


def _tickets(redis: Redis, app: Celery) -> int:
    return sum(int(redis.llen(key)) for key in broker.ticket_keys(app))


@pytest.mark.timeout(60)
def test_a_process_that_is_not_ready_leaves_its_ticket_to_one_that_is(
    backend: Backend, redis: Redis
) -> None:
    app = broker.celery_app(backend.settings)
    host = Host(backend.settings, "w", IsolationLevel.NONE, (), ())
    run_id = backend.queue("ann")

    with closing(
        RunLoop(
            app,
            backend.settings,
            host,
            index=0,
            shutting_down=lambda: False,
            simulator=StartingSimulator(),  # type: ignore[arg-type]
        )
    ) as loop:
        before = _tickets(redis, app)
        loop.run_next()
        after = _tickets(redis, app)

    assert backend.show(run_id).state is RunState.QUEUED
    assert after == before + 1
    app.close()
