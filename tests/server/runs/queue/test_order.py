"""The order that pages foresee is the one that follows from the rule of a claim, run by run."""

from itertools import count

from hypothesis import given
from hypothesis import strategies as st

from seamark.server.database.queue_tables import Turn
from seamark.server.database.tables import Run
from seamark.server.runs.queue import order, start_order, wait_estimate
from tests.cast import Backend

ROWS = st.lists(
    st.tuples(st.integers(0, 3), st.sampled_from([0.0, 1.0, 2.0]), st.integers(1, 4)),
    min_size=1,
    max_size=5,
)


def _turns(rows: list[tuple[int, float, int]]) -> list[Turn]:
    return [
        Turn(owner=f"user:{at}", running=running, served_at=served_at, next_run=at, queued=queued)
        for at, (running, served_at, queued) in enumerate(rows)
    ]


def _claimed(rows: list[tuple[int, float, int]]) -> list[str]:
    """Return the owners as claims one after the other serve them."""
    waiting, served, clock = _turns(rows), list[str](), count(10)
    while any(turn.queued for turn in waiting):
        ready = [turn for turn in waiting if turn.queued]
        first = min(ready, key=lambda turn: (turn.running, turn.served_at, turn.next_run))
        first.running, first.served_at = first.running + 1, float(next(clock))
        first.queued -= 1
        served.append(first.owner)
    return served


@given(rows=ROWS)
def test_the_key_orders_runs_as_claims_one_after_the_other(
    rows: list[tuple[int, float, int]],
) -> None:
    keys = [
        (order.key(turn, number), turn.owner)
        for turn in _turns(rows)
        for number in range(turn.queued)
    ]

    assert [owner for _, owner in sorted(keys)] == _claimed(rows)


@given(accounts=st.integers(0, 12), guests=st.integers(0, 5), passed_over=st.integers(0, 4))
def test_the_shares_are_counted_as_they_are_mixed(
    accounts: int, guests: int, passed_over: int
) -> None:
    mixed = list(
        order.in_shares(
            [("account", n) for n in range(accounts)],
            [("guest", n) for n in range(guests)],
            passed_over=passed_over,
        )
    )

    for at, (kind, number) in enumerate(mixed):
        if kind == "account":
            among = order.guests_among(number, passed_over=passed_over)
            assert at == number + min(among, guests)
        else:
            before = order.accounts_before(number, passed_over=passed_over)
            assert at == number + min(max(before, 0), accounts)


def test_the_position_of_a_run_is_the_one_at_which_it_starts(both: Backend) -> None:
    both.settings = both.settings.model_copy(update={"running_max": 100, "quota_live": 100})
    both.queue("ben")
    both.claim_next()
    for who in ("ann", "ann", "ann", "ben", "ben", "guest", "eva"):
        both.queue(who)

    with both.database.reading() as session:
        listed = start_order.first(session, 100)
        positions = {
            run_id: wait_estimate.wait_of(session, session.get_one(Run, run_id), both.settings)
            for run_id in listed
        }

    assert [positions[run_id].position for run_id in listed] == list(range(1, 8))
