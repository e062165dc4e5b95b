from pathlib import Path

from redis import Redis

from seamark.embedded import broker as embedded
from seamark.server.messaging import broker
from seamark.server.settings import Settings


def test_a_broker_without_memory_refuses_tickets_which_are_sent_later(settings: Settings) -> None:
    app = broker.celery_app(settings)
    with Redis.from_url(settings.broker_url) as redis:
        redis.config_set("maxmemory", 1)
        sent = broker.send_tickets(app)
        redis.config_set("maxmemory", 0)

        sent_later = broker.top_up(app, redis, needed=2)

    assert (sent, sent_later) == (False, 2)


def test_the_memory_of_the_embedded_broker_is_bounded_and_no_ticket_is_evicted() -> None:
    command = embedded.command(Path("valkey-server"), socket=Path("/s"), state=Path("/state"))
    options = dict(zip(command[1::2], command[2::2], strict=True))

    assert options["--maxmemory"] == embedded.MEMORY_MAX
    assert options["--maxmemory-policy"] == "noeviction"
