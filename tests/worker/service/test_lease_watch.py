import time

import pytest

from seamark.worker.service.lease_watch import LeaseWatch

HOUR_S = 3600.0


@pytest.fixture
def watch() -> LeaseWatch:
    return LeaseWatch(lease_s=30.0, renewal_s=5.0)


def test_a_lease_that_has_ended_is_abandoned_after_two_missed_renewals(watch: LeaseWatch) -> None:
    ended = {1: time.time() - 1.0}

    found = [watch.abandoned(ended, now_s=now_s) for now_s in (0.0, 9.9, 10.0)]

    assert found == [{}, {}, ended]


def test_a_live_lease_survives_a_clock_that_jumps_an_hour_ahead(watch: LeaseWatch) -> None:
    found = []
    for sweep in range(6):  # each time it has been renewed, but by a clock an hour behind
        renewed = {1: time.time() - HOUR_S + 10.0 * sweep}
        found.append(watch.abandoned(renewed, now_s=10.0 * sweep))

    assert found == [{}] * 6


def test_a_lease_of_a_dead_worker_ends_although_the_clock_jumped_an_hour_back(
    watch: LeaseWatch,
) -> None:
    ahead = {1: time.time() + HOUR_S}

    found = [watch.abandoned(ahead, now_s=now_s) for now_s in (0.0, 29.9, 30.0)]

    assert found == [{}, {}, ahead]


def test_a_lease_that_was_released_and_claimed_again_is_observed_anew(watch: LeaseWatch) -> None:
    end = time.time() - 1.0
    watch.abandoned({1: end}, now_s=0.0)
    watch.abandoned({}, now_s=10.0)

    assert watch.abandoned({1: end}, now_s=20.0) == {}
