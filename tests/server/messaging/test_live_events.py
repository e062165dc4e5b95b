from redis import Redis

from seamark.server.messaging import live_events
from tests.services import valkey


def test_a_state_reaches_all_who_listen_and_stays_nowhere(redis_url: str) -> None:
    with (
        Redis.from_url(redis_url) as redis,
        valkey.listening(redis_url) as first,
        valkey.listening(redis_url) as second,
    ):
        live_events.publish_state(redis, 7, "running", progress=0.5, t_simulated=3.0)

        heard = [first.states(), second.states()]
        keys = redis.keys("*")

    values = {"state": "running", "progress": 0.5, "t_simulated": 3.0, "position": None}
    assert heard == [[(7, values)]] * 2
    assert keys == []
