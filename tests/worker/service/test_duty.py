"""Which workers look after what all share."""

import time

from redis import Redis

from seamark.worker.service.duty import HOLDERS, Duty

KEPT_S = 60.0


def test_as_many_as_there_are_places_have_the_duty_and_keep_it(redis_url: str) -> None:
    redis = Redis.from_url(redis_url)
    processes = [Duty(redis, kept_s=KEPT_S) for _ in range(HOLDERS + 2)]

    first = [process.is_mine() for process in processes]
    second = [process.is_mine() for process in processes]

    assert first == second == [True] * HOLDERS + [False] * 2


def test_a_place_that_is_given_up_or_not_kept_goes_to_another(redis_url: str) -> None:
    redis = Redis.from_url(redis_url)
    stopped, silent, *steady = [Duty(redis, kept_s=KEPT_S) for _ in range(HOLDERS - 1)] + [
        Duty(redis, kept_s=0.05)
    ]
    first, second = (Duty(redis, kept_s=KEPT_S) for _ in range(2))
    assert all(process.is_mine() for process in (stopped, silent, *steady))

    stopped.give_up()
    assert first.is_mine()
    time.sleep(0.1)
    assert second.is_mine()

    assert not any(process.is_mine() for process in (stopped, *steady))


def test_without_a_broker_everybody_has_the_duty() -> None:
    nowhere = Redis.from_url("unix:///nowhere.sock")

    assert all(Duty(nowhere, kept_s=KEPT_S).is_mine() for _ in range(HOLDERS + 1))
