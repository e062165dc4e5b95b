"""The order in which the queued runs will start, as far as a page shows it.

As if no run ended or was submitted meanwhile.
"""

import heapq
from collections import Counter, deque
from collections.abc import Iterator
from itertools import islice

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from seamark.server.database.queue_tables import Turn
from seamark.server.database.tables import IS_QUEUED, Run
from seamark.server.runs.queue import order
from seamark.server.runs.record import turns
from seamark.server.runs.record.turns import Priority


def first(session: Session, limit: int) -> list[int]:
    """Return the runs that start next, in order, at most `limit`."""
    owners = list(islice(_owners(session, limit), limit))
    waiting = _oldest(session, Counter(owners))
    return [waiting[owner].popleft() for owner in owners if waiting.get(owner)]


def _owners(session: Session, limit: int) -> Iterator[str]:
    """Yield the owner of each run that starts."""
    accounts, guests, *others = (_of_priority(session, each, limit) for each in Priority)
    passed_over = order.passed_over(session)
    yield from order.in_shares(accounts, guests, passed_over=passed_over)
    for each in others:
        yield from each


def _of_priority(session: Session, priority: Priority, limit: int) -> list[str]:
    """Return the owners of one priority in turn, once for each of their runs."""
    query = select(Turn).where(turns.IS_WAITING, Turn.priority == int(priority))
    rows = session.scalars(query.order_by(*order.columns(Turn)).limit(limit)).all()
    in_turn = heapq.merge(*map(_runs_of, rows))
    return [owner for _, owner in islice(in_turn, limit)]


def _runs_of(turn: Turn) -> Iterator[tuple[order.Key, str]]:
    """Yield what orders each queued run of an owner, the next one first."""
    return ((order.key(turn, number), turn.owner) for number in range(turn.queued))


def _oldest(session: Session, counts: Counter[str]) -> dict[str, deque[int]]:
    """Return the oldest queued runs of owners, as many of each as `counts` says."""
    number = func.row_number().over(partition_by=Run.owner, order_by=Run.id).label("number")
    each = select(Run.owner, Run.id, number).where(Run.owner.in_(counts), IS_QUEUED).subquery()
    most = max(counts.values(), default=0)
    query = select(each.c.owner, each.c.id).where(each.c.number <= most).order_by(each.c.id)
    by_owner = dict[str, deque[int]]()
    for owner, run_id in session.execute(query):
        by_owner.setdefault(owner, deque()).append(run_id)
    return by_owner
