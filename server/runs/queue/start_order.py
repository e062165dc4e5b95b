"""The order in which the queued runs will start, as far as a page shows it.

It follows the rule of `queue.claim` on the rows of the owners, as if no run ended or was submitted
meanwhile.
"""

import heapq
import time
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from itertools import islice

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from seamark.server.database.queue_tables import Turn
from seamark.server.database.tables import IS_QUEUED, Run
from seamark.server.runs.queue import guest_share
from seamark.server.runs.record import turns
from seamark.server.runs.record.turns import Priority


def first(session: Session, limit: int) -> list[int]:
    """Return the runs that start next, in order, at most `limit`."""
    owners = list(islice(_owners(session, limit), limit))
    waiting = _oldest(session, Counter(owners))
    return [waiting[owner].popleft() for owner in owners if waiting.get(owner)]


def _owners(session: Session, limit: int) -> Iterator[str]:
    """Yield the owner of each run that starts."""
    accounts, guests, *others = (
        deque(islice(_of_priority(session, priority, limit), limit)) for priority in Priority
    )
    passed_over = guest_share.passed_over(session)
    while accounts:
        if guests and passed_over >= guest_share.GUEST_SHARE:
            yield guests.popleft()
            passed_over = 0
        yield accounts.popleft()
        passed_over += 1
    for each in (guests, *others):
        yield from each


def _of_priority(session: Session, priority: Priority, limit: int) -> Iterator[str]:
    """Yield the owners of one priority in turn: those with the fewest running runs first."""
    order = (Turn.running, Turn.served_at, Turn.next_run)
    query = select(Turn).where(turns.IS_WAITING, Turn.priority == int(priority))
    rows: Sequence[Turn] = session.scalars(query.order_by(*order).limit(limit)).all()
    heap = [(row.running, row.served_at, row.next_run or 0, row.owner, row.queued) for row in rows]
    served_at = time.time()
    while heap:
        running, _, next_run, owner, left = heapq.heappop(heap)
        yield owner
        served_at += 1.0  # whoever was served goes behind everybody else with as many running runs
        if left > 1:
            heapq.heappush(heap, (running + 1, served_at, next_run, owner, left - 1))


def _oldest(session: Session, counts: Counter[str]) -> dict[str, deque[int]]:
    """Return the oldest queued runs of owners, as many of each as `counts` says."""
    number = func.row_number().over(partition_by=Run.owner, order_by=Run.id).label("number")
    each = select(Run.owner, Run.id, number).where(Run.owner.in_(counts), IS_QUEUED).subquery()
    most = max(counts.values(), default=0)
    query = select(each.c.owner, each.c.id).where(each.c.number <= most).order_by(each.c.id)
    found = dict[str, deque[int]]()
    for owner, run_id in session.execute(query):
        found.setdefault(owner, deque()).append(run_id)
    return found
