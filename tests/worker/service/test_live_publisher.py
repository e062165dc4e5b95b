from redis import Redis

from seamark.server.messaging import live_events
from seamark.worker.service.live_publisher import LivePublisher


def test_what_a_program_prints_is_published_as_printable_text(redis_url: str) -> None:
    with Redis.from_url(redis_url) as redis:
        LivePublisher(redis, 7).log("\x1b]0;title\x07 \u202eabc\n".encode())

        (event,) = live_events.history(redis, 7, None)

    assert event.data == {"text": "\\x1b]0;title\\x07 \\u202eabc\n"}
