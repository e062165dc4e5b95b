"""Turns: users share the places, guests have a small share, and nobody has them all."""

from typing import Any

import pytest

from seamark.server.accounts.permissions import Viewer
from seamark.server.database.tables import Worker
from seamark.server.messaging import workers
from tests.cast import Backend


def test_users_take_turns_however_many_runs_they_queue(both: Backend) -> None:
    anns = [both.queue("ann") for _ in range(4)]
    bens = [both.queue("ben") for _ in range(2)]

    order = []
    while (claim := both.claim()) is not None:
        order.append(claim.run_id)
        both.finish(claim)

    assert order == [anns[0], bens[0], anns[1], bens[1], anns[2], anns[3]]


def _guest(both: Backend, cookie: str, network: str) -> str:
    both.viewers[cookie] = Viewer(guest=cookie, network=network)
    return cookie


def _drained(both: Backend) -> list[int]:
    """Return the queued runs in the order in which they are claimed, one after the other."""
    order = []
    while (claim := both.claim()) is not None:
        order.append(claim.run_id)
        both.finish(claim)
    return order


def test_runs_of_accounts_start_before_those_of_guests(both: Backend) -> None:
    guests = [both.queue(_guest(both, f"g{number}", f"n{number}")) for number in range(4)]
    anns = [both.queue("ann") for _ in range(2)]

    positions = [both.show(run_id).position for run_id in [*anns, *guests]]

    assert positions == [1, 2, 3, 4, 5, 6]
    assert _drained(both) == [*anns, *guests]


def test_guests_wait_longer_than_accounts_but_not_for_ever(both: Backend) -> None:
    guests = [both.queue(_guest(both, f"g{number}", f"n{number}")) for number in range(3)]
    names = [both.sign_up(f"user{number}").name for number in range(5)]
    accounts = [both.queue(name) for _ in range(2) for name in names]

    order = [*accounts[:4], guests[0], *accounts[4:8], guests[1], *accounts[8:], guests[2]]
    positions = [both.show(run_id).position for run_id in order]

    assert positions == list(range(1, 14))
    assert _drained(both) == order


@pytest.mark.slow
def test_the_positions_stay_right_while_guests_have_their_share(both: Backend) -> None:
    names = [both.sign_up(f"user{number}").name for number in range(4)]
    queued = [both.queue(name) for _ in range(3) for name in names]
    queued += [both.queue(_guest(both, f"g{number}", f"n{number % 3}")) for number in range(5)]

    while queued:
        positions = {both.show(run_id).position: run_id for run_id in queued}
        assert sorted(filter(None, positions)) == list(range(1, len(queued) + 1))
        claim = both.claim_next()
        assert claim.run_id == positions[1]
        queued.remove(claim.run_id)
        both.finish(claim)


def test_guests_of_one_network_take_one_turn_between_them(both: Backend) -> None:
    first, second = (both.queue(_guest(both, f"a{number}", "n1")) for number in range(2))
    other = both.queue(_guest(both, "b", "n2"))

    assert _drained(both) == [first, other, second]


def test_the_user_with_most_running_runs_waits_for_the_others(both: Backend) -> None:
    for _ in range(3):
        both.queue("ann")
    both.claim()
    both.claim()
    late = both.queue("ben")

    claim = both.claim_next()

    assert claim.run_id == late


def test_no_user_has_more_running_runs_than_the_limit(both: Backend) -> None:
    for _ in range(5):
        both.queue("ann")

    claims = [both.claim() for _ in range(5)]

    assert sum(claim is not None for claim in claims) == both.settings.running_max


def _slots(both: Backend, *workers_slots: int) -> None:
    with both.database.writing() as session:
        for number, slots in enumerate(workers_slots):
            values: dict[str, list[Any]] = {"languages": [], "findings": []}
            workers.register(
                session, Worker(name=f"host{number}", slots=slots, level="none", **values)
            )


@pytest.mark.parametrize(("slots", "running"), [((1,), 1), ((2,), 1), ((1, 2), 2), ((8,), 4)])
def test_one_user_never_has_all_places_of_the_living_workers(
    both: Backend, slots: tuple[int, ...], running: int
) -> None:
    _slots(both, *slots)
    anns = [both.queue("ann") for _ in range(5)]

    claims = [both.claim() for _ in range(sum(slots))]

    assert sum(claim is not None for claim in claims) == running
    own = "your run has" if running == 1 else f"one of your {running} runs has"
    assert f"It waits until {own} ended" in (both.show(anns[-1]).why_waiting or "")
    assert sum(slots) == running or both.running("ben").attempt == 1


def test_the_positions_in_the_queue_are_the_order_of_claims(both: Backend) -> None:
    queued = [both.queue(who) for who in ("ann", "ann", "ann", "ben", "ben", "eva")]
    places = {run_id: both.show(run_id).position for run_id in queued}

    order = []
    while (claim := both.claim()) is not None:
        order.append(claim.run_id)
        both.finish(claim)

    assert [places[run_id] for run_id in order] == [1, 2, 3, 4, 5, 6]
