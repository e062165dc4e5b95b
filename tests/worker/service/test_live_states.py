from redis import Redis

from seamark.server.runs.record.states import RunState
from seamark.worker.service.live_states import LivePublisher
from tests.services import valkey


def test_the_state_of_a_run_is_published(redis_url: str) -> None:
    with Redis.from_url(redis_url) as redis, valkey.listening(redis_url) as listener:
        LivePublisher(redis, 7).state(RunState.RUNNING, progress=0.25, t_simulated=2.0)

        ((run_id, values),) = listener.states()

    assert (run_id, values["state"], values["progress"]) == (7, "running", 0.25)


def test_a_broker_that_is_away_does_not_stop_a_run() -> None:
    with Redis.from_url("unix:///nothing/here") as redis:
        LivePublisher(redis, 7).state(RunState.RUNNING, progress=0.25, t_simulated=2.0)
