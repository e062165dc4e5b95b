from redis import Redis

from seamark.server.runs.ending import cancellation
from seamark.server.runs.record.states import RunState
from tests.cast import Backend
from tests.services import valkey


def test_viewers_of_a_queued_run_are_told_that_it_is_cancelled(
    backend: Backend, redis_url: str
) -> None:
    run_id = backend.queue("ann")

    with Redis.from_url(redis_url) as redis, valkey.listening(redis_url) as listener:
        cancelled = cancellation.cancel(backend.database, redis, run_id)
        ((told_of, values),) = listener.states()

    assert cancelled
    assert backend.show(run_id).state is RunState.CANCELLED
    assert (told_of, values["state"]) == (run_id, "cancelled")


def test_the_viewers_of_a_running_run_are_left_to_its_worker(
    backend: Backend, redis_url: str
) -> None:
    run_id = backend.running("ann").run_id

    with Redis.from_url(redis_url) as redis, valkey.listening(redis_url) as listener:
        cancelled = cancellation.cancel(backend.database, redis, run_id)
        told = listener.states()

    assert (cancelled, told) == (True, [])
    assert backend.show(run_id).state is RunState.CANCELLED


def test_a_run_that_has_ended_cannot_be_cancelled(backend: Backend, redis_url: str) -> None:
    run_id = backend.succeeded("ann")

    with Redis.from_url(redis_url) as redis, valkey.listening(redis_url) as listener:
        assert not cancellation.cancel(backend.database, redis, run_id)
        assert listener.states() == []


def test_a_run_is_cancelled_even_when_the_broker_is_away(backend: Backend) -> None:
    run_id = backend.queue("ann")

    with Redis.from_url("unix:///nothing/here") as redis:
        assert cancellation.cancel(backend.database, redis, run_id)

    assert backend.show(run_id).state is RunState.CANCELLED
