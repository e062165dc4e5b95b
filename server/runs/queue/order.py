"""The order of the queue, in one place: for claims, and for pages that foresee them.

1. Runs of accounts come first, then those of guests, then baselines, then recomputations.
2. After `GUEST_SHARE` runs of accounts that start while guests wait, a guest's run starts.
3. Within a priority the owner with the fewest running runs goes first, then the one whose last run
   started longest ago, then the one with the oldest run.

Each run of an account that starts while a guest waits leaves a row: a number that all of them
change would be a row that all claims wait for. Claims at the same time do not see each other's: for
n of them, up to 2 (n - 1) more accounts go first.
"""

from collections import deque
from collections.abc import Iterable, Iterator
from typing import Any, TypeVar

from sqlalchemy import ColumnElement, ScalarSelect, and_, case, or_
from sqlalchemy.orm import InstrumentedAttribute, Session

from seamark.server.accounts.permissions import GUESTS
from seamark.server.database import counters
from seamark.server.database.queue_tables import Turn
from seamark.server.runs.record.turns import Priority

GUEST_SHARE = 4  # runs of accounts that start before one of a guest, while both wait
_PASSED_OVER = "guests_passed_over"
_Run = TypeVar("_Run")
Key = tuple[int, int, float, int]


def priorities(*, guests_first: bool) -> Iterator[Priority]:
    """Yield the priorities in the order in which a claim looks for a run."""
    if guests_first:
        yield Priority.GUEST
    for priority in Priority:
        if not (guests_first and priority is Priority.GUEST):
            yield priority


def columns(turn: type[Turn]) -> tuple[InstrumentedAttribute[Any], ...]:
    """Return what orders the owners of one priority, for the next run of each."""
    return (turn.running, turn.served_at, turn.next_run)


def key(turn: Turn, number: int) -> Key:
    """Return what orders the queued runs of one priority; `number` counts those of the owner.

    It is that of `columns` when all runs before have started and none has ended: of two owners who
    then have as many running runs, the one who has more of them now was served earlier.
    """
    return (turn.running + number, -turn.running, turn.served_at, turn.next_run or 0)


def runs_before(mine: Turn, number: int) -> ColumnElement[int]:
    """Return how many queued runs of the owner of a row start before one of `mine`, as `key`."""
    earlier = or_(
        Turn.running > mine.running,
        and_(
            Turn.running == mine.running,
            or_(
                Turn.served_at < mine.served_at,
                and_(Turn.served_at == mine.served_at, Turn.next_run < mine.next_run),
            ),
        ),
    )
    rounds = mine.running + number - Turn.running + case((earlier, 1), else_=0)
    return case((rounds <= 0, 0), (rounds >= Turn.queued, Turn.queued), else_=rounds)


def in_shares(
    accounts: Iterable[_Run], guests: Iterable[_Run], *, passed_over: int
) -> Iterator[_Run]:
    """Yield the runs of accounts and guests in the order in which they start.

    Parameters
    ----------
    passed_over
        Runs of accounts that have started since the last one of a guest, while guests waited.
    """
    left = deque(guests)
    for run in accounts:
        if left and passed_over >= GUEST_SHARE:
            yield left.popleft()
            passed_over = 0
        yield run
        passed_over += 1
    yield from left


def guests_among(accounts: int, *, passed_over: int) -> int:
    """Return how many runs of guests start before the run after so many of accounts."""
    return (accounts + passed_over) // GUEST_SHARE


def accounts_before(guests: int, *, passed_over: int) -> int:
    """Return how many runs of accounts start before the run after so many of guests."""
    return GUEST_SHARE * (guests + 1) - passed_over


def passed_over(session: Session) -> int:
    """Return how many runs of accounts have started while guests waited, since one of theirs."""
    return int(counters.total(session, _PASSED_OVER))


def stored_passed_over() -> ScalarSelect[float]:
    """Return `passed_over` as an expression, for a query that asks for more; NULL for 0."""
    return counters.stored_total(_PASSED_OVER)


def count_start(
    session: Session, owner: str, run_id: int, *, before: int, guests_wait: bool
) -> None:
    """Count a run that starts.

    Parameters
    ----------
    owner
        Of the run.
    before
        How many have passed guests over until now.
    """
    if not guests_wait or owner.startswith(GUESTS):
        if before:
            counters.forget(session, _PASSED_OVER)
    elif before < GUEST_SHARE:
        counters.add(session, f"{_PASSED_OVER}:{run_id}", 1.0)
