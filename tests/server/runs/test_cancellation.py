from redis import Redis

from seamark.server.messaging import live_events
from seamark.server.runs import cancellation
from seamark.server.runs.states import RunState
from tests.cast import Backend


def _events(redis: Redis, run_id: int) -> list[tuple[str, object]]:
    return [(event.type, event.data.get("state")) for event in live_events.history(redis, run_id)]


def test_the_streams_of_a_queued_run_end_when_it_is_cancelled(
    both: Backend, redis_url: str
) -> None:
    run_id = both.queue("ann")

    with Redis.from_url(redis_url) as redis:
        cancelled = cancellation.cancel(both.database, redis, run_id)
        events = _events(redis, run_id)

    assert cancelled
    assert both.show(run_id).state is RunState.CANCELLED
    assert events == [(live_events.STATE, "cancelled"), (live_events.END, None)]


def test_the_streams_of_a_running_run_are_left_to_its_worker(both: Backend, redis_url: str) -> None:
    run_id = both.running("ann").run_id

    with Redis.from_url(redis_url) as redis:
        cancelled = cancellation.cancel(both.database, redis, run_id)
        events = _events(redis, run_id)

    assert (cancelled, events) == (True, [])
    assert both.show(run_id).state is RunState.CANCELLED


def test_a_run_that_has_ended_cannot_be_cancelled(both: Backend, redis_url: str) -> None:
    run_id = both.succeeded("ann")

    with Redis.from_url(redis_url) as redis:
        assert not cancellation.cancel(both.database, redis, run_id)
        assert _events(redis, run_id) == []


def test_a_run_is_cancelled_even_when_the_broker_is_away(both: Backend) -> None:
    run_id = both.queue("ann")

    with Redis.from_url("unix:///nothing/here") as redis:
        assert cancellation.cancel(both.database, redis, run_id)

    assert both.show(run_id).state is RunState.CANCELLED
