"""Which queued run starts next: finds it and locks it, without a lock that all claims share.

On PostgreSQL a claim locks the row of one owner and passes over those that others have locked. So a
machine that vanishes in the middle of a claim stops one owner until the server ends its session,
not the queue. Whoever has an owner's row is the only one that starts a run of the owner, so that
nobody exceeds the limit.

The order is that of claims one after the other: a locked row is that of an owner who gets a run
just now, after which the next owner is in turn. Where that owner would be first even then, the
claim has to wait.
"""

from collections.abc import Collection

from sqlalchemy import (
    ColumnElement,
    Select,
    String,
    and_,
    bindparam,
    case,
    func,
    literal,
    or_,
    select,
    true,
)
from sqlalchemy.orm import Session, aliased

from seamark.server.database.advisory_locks import AdvisoryLock, try_acquire
from seamark.server.database.queue_tables import Turn
from seamark.server.database.tables import IS_QUEUED, Run, RunPart
from seamark.server.runs.queue import order
from seamark.server.runs.record import turns
from seamark.server.runs.record.turns import Priority

_MANY = 2**30  # more runs than anybody has running
# The languages of a worker: twice, because an empty list is written otherwise after NOT.
_LANGUAGES = bindparam("languages", expanding=True, type_=String)
_NO_OTHERS = bindparam("no_others", expanding=True, type_=String)
_UNSUITABLE_PART = select(RunPart.run_id).where(
    RunPart.run_id == Run.id, RunPart.language.not_in(_NO_OTHERS)
)
_SUITABLE = and_(
    or_(Run.language.is_(None), Run.language.in_(_LANGUAGES)), ~_UNSUITABLE_PART.exists()
)


class TurnTaken(Exception):
    """Another transaction has the row of the owner whose turn it is: wait for it, and try again."""

    def __init__(self, owner: str) -> None:
        super().__init__(owner)
        self.owner = owner


def _may_start(turn: type[Turn]) -> list[ColumnElement[bool]]:
    """Return the conditions under which a run of an owner may start on a worker."""
    run = select(Run.id).where(Run.owner == turn.owner, IS_QUEUED, _SUITABLE).correlate(turn)
    return [
        turns.is_waiting(turn),
        turn.priority == bindparam("priority"),
        turn.running < bindparam("limit"),
        run.exists(),
    ]


def _locking() -> Select[str, str]:
    """Lock the row of the owner whose turn it is; select the owner, and another one to wait for.

    That is an owner whose row is locked and who would be first even with another running run, or
    the same one if the row has changed since the order was looked at.
    """
    first = select(Turn.owner, Turn.running, Turn.served_at).where(*_may_start(Turn))
    first = first.order_by(*order.columns(Turn)).limit(1).with_for_update(skip_locked=True)
    mine, one = first.cte("mine"), select(literal(1)).subquery("one")
    seen, other = aliased(Turn, name="seen"), aliased(Turn, name="other")
    changed = or_(seen.running != mine.c.running, seen.served_at != mine.c.served_at)
    running = func.coalesce(mine.c.running, _MANY)
    ahead = select(other.owner).where(*_may_start(other), other.running < running - 1)
    ahead = ahead.order_by(*order.columns(other)).limit(1).correlate(mine)
    taken = func.coalesce(ahead.scalar_subquery(), case((changed, mine.c.owner)))
    query = one.outerjoin(mine, true()).outerjoin(seen, seen.owner == mine.c.owner)
    return select(mine.c.owner, taken).select_from(query)


def _oldest() -> Select[int]:
    """Lock the oldest run of an owner; one that is being cancelled is passed over."""
    query = select(Run.id).where(Run.owner == bindparam("owner"), IS_QUEUED, _SUITABLE)
    return query.order_by(Run.id).limit(1).with_for_update(skip_locked=True)


# Built once: building them takes longer than the database with them.
_LOCKING, _OLDEST = _locking(), _oldest()
_ANYBODY = select(Turn.owner).where(*_may_start(Turn)).limit(1)


def _bound(languages: Collection[str]) -> dict[str, object]:
    """Return the parameters of `_SUITABLE`."""
    return dict.fromkeys((_LANGUAGES.key, _NO_OTHERS.key), sorted(languages))


def may_start(session: Session, languages: Collection[str], limit: int) -> bool:
    """Return whether there is a run that a claim would start now, without a lock."""
    for priority in Priority:
        if priority is Priority.BASELINE and _baseline_runs(session):
            continue
        bound = _bound(languages) | {"priority": int(priority), "limit": limit}
        if session.connection().scalar(_ANYBODY, bound) is not None:
            return True
    return False


def find(
    session: Session,
    languages: Collection[str],
    limit: int,
    *,
    guests_first: bool,
    patient: bool,
) -> tuple[int, Priority] | None:
    """Return the run that starts next, and lock it with its owner's row; None without one.

    Parameters
    ----------
    limit
        The most runs of one owner that may run.
    patient
        Do not pass over an owner who would be first.

    Raises
    ------
    TurnTaken
        The caller has to end the transaction, to wait for the owner and to try again.
    """
    suitable = _bound(languages)
    for priority in order.priorities(guests_first=guests_first):
        if priority is Priority.BASELINE and not _baseline_may_start(session):
            continue
        bound = suitable | {"priority": int(priority), "limit": limit}
        owner, taken = session.connection().execute(_LOCKING, bound).one()
        if taken is not None and patient:
            raise TurnTaken(taken)
        if owner is None:
            continue
        run_id = session.connection().scalar(_OLDEST, suitable | {"owner": owner})
        if run_id is not None:
            return run_id, priority
        if patient:
            raise TurnTaken(owner)
    return None


def _baseline_may_start(session: Session) -> bool:
    """Return whether no baseline runs or starts: one at a time, however many there are."""
    return try_acquire(session, AdvisoryLock.BASELINE_TURN) and not _baseline_runs(session)


def _baseline_runs(session: Session) -> bool:
    running = select(Turn.owner).where(turns.IS_SERVED, Turn.priority == int(Priority.BASELINE))
    return session.scalar(running.limit(1)) is not None
