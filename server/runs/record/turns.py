"""Whose turn it is: a row for each owner in the queue, so that it costs the same at any depth.

Whoever changes a live run calls `refresh` afterwards, in the same transaction. The row is counted
anew from the owner's live runs, which are few, so that no mistake lasts.
"""

import time
from collections.abc import Collection
from dataclasses import dataclass
from enum import IntEnum

from sqlalchemy import (
    ColumnElement,
    Float,
    String,
    Update,
    bindparam,
    delete,
    func,
    literal,
    select,
    text,
    update,
)
from sqlalchemy.exc import OperationalError
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import GUESTS, REJUDGEMENTS
from seamark.server.database.queue_tables import Turn
from seamark.server.database.tables import IS_QUEUED, IS_RUNNING, Run, User
from seamark.server.database.upsert import upsert
from seamark.server.runs.record.solutions import IS_CONNECTED

_NONE = literal(0, literal_execute=True)  # in the statement itself, as in the partial indexes
IS_SERVED = Turn.running > _NONE
_KEPT_S = 86_400.0  # after the last start of a run: for so long an owner has had a turn
_USERS = "user:"
FREE_S = 1.0  # that a recovery waits for the row of an owner
_FREE_POLL_S = 0.02
_LOCK_NOT_AVAILABLE = "55P03"  # of PostgreSQL
_LOCK_TIMEOUT = text("SELECT set_config('lock_timeout', :limit, true)")


class TurnKept(Exception):
    """A transaction keeps the row of an owner: its machine may have vanished."""


def is_waiting(turn: type[Turn] = Turn) -> ColumnElement[bool]:
    """Return whether an owner has queued runs, for one of several rows in a query."""
    return turn.queued > _NONE


IS_WAITING = is_waiting()


class Priority(IntEnum):
    """Whose runs start first; guests have a share all the same, see `queue.claim`."""

    ACCOUNT = 0
    GUEST = 1
    BASELINE = 2
    REJUDGEMENT = 3

    @property
    def label(self) -> str:
        """What operators call the runs of this priority."""
        return self.name.lower()


def _counting() -> Update:
    owner = bindparam("this", type_=String)
    queued = (Run.owner == owner, IS_QUEUED)
    # Connected programs have slots of their own, which no other run could have.
    running = (Run.owner == owner, IS_RUNNING, ~IS_CONNECTED)
    counted = {
        "queued": select(func.count()).select_from(Run).where(*queued),
        "running": select(func.count()).select_from(Run).where(*running),
        "next_run": select(func.min(Run.id)).where(*queued),
        "expected_s": select(func.coalesce(func.sum(Run.expected_s), 0.0)).where(*queued),
    }
    values = {name: query.scalar_subquery() for name, query in counted.items()}
    served_at = func.coalesce(bindparam("served", type_=Float), Turn.served_at)
    return update(Turn).where(Turn.owner == owner).values(served_at=served_at, **values)


# Built once: building them takes longer than the database with them.
_COUNTING = _counting()
_LOCKING = select(Turn.owner).where(Turn.owner == bindparam("this")).with_for_update()


def refresh(session: Session, owner: str, *, served: bool = False) -> None:
    """Count the live runs of an owner anew.

    Parameters
    ----------
    served
        A run of the owner starts: the others have their turns before the next one.
    """
    session.flush()
    _lock(session, owner)
    # A new statement: on PostgreSQL it sees what the transaction that had the lock has committed.
    values = {"this": owner, "served": time.time() if served else None}
    session.connection().execute(_COUNTING, values)


def serve_first(session: Session, owner: str) -> None:
    """Let an owner whose turn was lost go first among those of the same priority."""
    session.execute(
        update(Turn).where(Turn.owner == owner).values(served_at=0.0),
        execution_options={"synchronize_session": False},
    )


@dataclass(frozen=True, slots=True)
class PriorityLoad:
    """What waits of one priority."""

    name: str
    queued: int
    oldest_at: float | None  # None: nothing waits


def loads(session: Session) -> list[PriorityLoad]:
    """Return what waits of each priority, at the cost of a row for each owner who waits."""
    queued_at = select(Run.queued_at).where(Run.id == Turn.next_run).scalar_subquery()
    waiting = (
        select(Turn.priority, func.sum(Turn.queued), func.min(queued_at))
        .where(IS_WAITING)
        .group_by(Turn.priority)
    )
    rows = {priority: rest for priority, *rest in session.execute(waiting)}
    return [PriorityLoad(each.label, *rows.get(int(each), (0, None))) for each in Priority]


def rebuild(session: Session) -> None:
    """Count the rows of all owners anew, after changes of the tables by hand."""
    live = select(Run.owner).where(IS_QUEUED | IS_RUNNING)
    for owner in session.scalars(live.union(select(Turn.owner))).all():
        refresh(session, owner)


def forget_idle(session: Session) -> None:
    """Delete the owners without live runs who had no turn for a day."""
    idle = (Turn.queued == _NONE, Turn.running == _NONE, Turn.served_at < time.time() - _KEPT_S)
    free = select(Turn.owner).where(*idle).with_for_update(skip_locked=True)
    session.execute(
        delete(Turn).where(Turn.owner.in_(free)), execution_options={"synchronize_session": False}
    )


def wait_for(session: Session, owner: str, *, within_s: float) -> None:
    """Lock the row of an owner, waiting in a line with others.

    Raises
    ------
    TurnKept
        Another transaction has kept it all the time.
    """
    shortest_ms = max(round(within_s * 1000), 1)  # 0 would be for ever
    session.execute(_LOCK_TIMEOUT, {"limit": str(shortest_ms)})
    try:
        session.execute(_LOCKING, {"this": owner})
    except OperationalError as error:
        if getattr(error.orig, "sqlstate", None) == _LOCK_NOT_AVAILABLE:
            raise TurnKept(owner) from None
        raise


def lock_free(session: Session, owners: Collection[str]) -> set[str]:
    """Lock the rows of owners, and return the owners whose runs the caller may change now.

    Those whose rows another transaction keeps for longer are left out: its machine may have
    vanished.
    """
    rows = select(Turn.owner).where(Turn.owner.in_(sorted(owners))).order_by(Turn.owner)
    until = time.monotonic() + FREE_S
    while True:
        free = set(session.scalars(rows.with_for_update(skip_locked=True)))
        taken = set(session.scalars(rows)) - free
        if not taken or time.monotonic() > until:
            return set(owners) - taken
        time.sleep(_FREE_POLL_S)


def _lock(session: Session, owner: str) -> None:
    """Lock the row of an owner until the end of the transaction; insert it if it is missing."""
    if session.connection().scalar(_LOCKING, {"this": owner}) is not None:
        return
    priority = int(_priority(session, owner))
    row = {"owner": owner, "priority": priority, "served_at": 0.0}
    upsert(session, Turn, row, {"priority": priority})


def _priority(session: Session, owner: str) -> Priority:
    if owner.startswith(GUESTS):
        return Priority.GUEST
    if owner.startswith(REJUDGEMENTS):
        return Priority.REJUDGEMENT
    number = owner.removeprefix(_USERS) if owner.startswith(_USERS) else ""
    is_baseline = select(User.is_baseline).where(User.id == int(number or 0))
    return Priority.BASELINE if session.scalar(is_baseline) else Priority.ACCOUNT
