import asyncio
from typing import Any

import pytest
from redis import Redis
from redis import asyncio as redis_asyncio

from seamark.server.messaging import live_data
from seamark.server.messaging.live_data import Increment, Piece


def test_an_increment_arrives_as_it_was_published(redis_url: str) -> None:
    rows = Piece("telemetry.f64", 1, 480, 960, b"\n\x00\xff" * 100)
    log = Piece("log.txt", 0, 0, 4, "überall\n".encode())
    sent = Increment(2, [rows, log], {"columns.json": b'["t"]'})
    with Redis.from_url(redis_url) as redis:
        channel: Any = redis.pubsub()
        channel.subscribe(live_data.channel(7))
        channel.get_message(timeout=10)  # that it has subscribed

        live_data.publish(redis, 7, sent)

        message = channel.get_message(timeout=10)
    assert live_data.run_of(message["channel"]) == 7
    assert live_data.parse(message["data"]) == sent


@pytest.mark.parametrize("message", [b"", b"{}", b"[1]\n", b'{"attempt": 1, "pieces": [[1]]}\n'])
def test_what_is_no_increment_is_refused(message: bytes) -> None:
    with pytest.raises(ValueError, match="no increment"):
        live_data.parse(message)


def test_the_mark_of_a_watched_run_changes_only_if_something_is_missing(redis_url: str) -> None:
    async def watch(missing: bool) -> None:
        async with redis_asyncio.Redis.from_url(redis_url) as redis:
            await live_data.watch(redis, {7: missing})

    with Redis.from_url(redis_url) as redis:
        marks = [live_data.mark(redis, 7)]
        for missing in (False, False, True):
            asyncio.run(watch(missing))
            marks.append(live_data.mark(redis, 7))
        (key,) = redis.keys("*")
        left_s = redis.ttl(key)

    assert marks[0] is None
    assert marks[1] == marks[2] != marks[3]
    assert 0 < left_s <= live_data.WATCHED_S
