import threading
from collections.abc import Iterator

import pytest
from redis import Redis

from seamark.server.messaging import live_events
from seamark.server.messaging.live_events import END, LOG, Event, Fanout, TooManyStreams


@pytest.fixture
def redis(redis_url: str) -> Iterator[Redis]:
    with Redis.from_url(redis_url) as client:
        yield client


@pytest.fixture
def fanout(redis: Redis) -> Iterator[Fanout]:
    made = Fanout(redis, streams_max=3)
    yield made
    made.close()


def _say(redis: Redis, run_id: int, *texts: str) -> None:
    for text in texts:
        live_events.append(redis, run_id, LOG, {"text": text})


def _texts(events: list[Event]) -> list[str]:
    return [event.data["text"] for event in events if event.type == LOG]


def test_a_late_client_gets_all_events_from_the_start(redis: Redis, fanout: Fanout) -> None:
    _say(redis, 1, "a", "b")
    live_events.append(redis, 1, END, {})

    assert _texts(list(fanout.subscribe(1))) == ["a", "b"]


def test_a_client_that_reconnects_resumes_after_its_last_event(
    redis: Redis, fanout: Fanout
) -> None:
    _say(redis, 1, "a", "b", "c")
    live_events.append(redis, 1, END, {})
    first = next(iter(fanout.subscribe(1)))

    assert _texts(list(fanout.subscribe(1, first.id))) == ["b", "c"]


@pytest.mark.parametrize("last_id", ["", "x", "1-2-3", "-1-0", "9" * 30 + "-0"])
def test_an_invalid_last_event_id_means_from_the_start(
    redis: Redis, fanout: Fanout, last_id: str
) -> None:
    _say(redis, 1, "a")
    live_events.append(redis, 1, END, {})

    assert _texts(list(fanout.subscribe(1, last_id))) == ["a"]


def test_many_clients_get_each_event_of_their_run_once_and_in_order(
    redis: Redis, fanout: Fanout
) -> None:
    received: dict[str, list[str]] = {}
    streams = {"one": fanout.subscribe(1), "too": fanout.subscribe(1), "two": fanout.subscribe(2)}
    _say(redis, 1, "early")

    def listen(name: str) -> None:
        received[name] = _texts(list(streams[name]))

    threads = [threading.Thread(target=listen, args=(name,)) for name in streams]
    for thread in threads:
        thread.start()
    for number in range(50):
        _say(redis, 1, f"1.{number}")
        _say(redis, 2, f"2.{number}")
    for run_id in (1, 2):
        live_events.append(redis, run_id, END, {})
    for thread in threads:
        thread.join(timeout=20)

    ones = ["early", *(f"1.{number}" for number in range(50))]
    assert received == {"one": ones, "too": ones, "two": [f"2.{number}" for number in range(50)]}
    assert fanout.open_streams == 0


def test_streams_beyond_the_cap_are_refused_at_once(fanout: Fanout) -> None:
    held = [fanout.subscribe(number) for number in range(3)]

    with pytest.raises(TooManyStreams):
        fanout.subscribe(9)
    assert len(held) == fanout.open_streams


def test_an_event_is_encoded_as_the_standard_requires() -> None:
    assert Event("5-0", LOG, {"text": "a\nb"}).sse() == (
        'id: 5-0\nevent: log\ndata: {"text": "a\\nb"}\n\n'
    )
    assert Event("", live_events.HEARTBEAT, {}).sse().startswith(":")
