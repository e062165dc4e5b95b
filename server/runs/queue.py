"""The queue: which run starts next, and what happens to runs whose worker died.

A claim is a lease of a few seconds that its holder renews by heartbeats. The attempt number is the
fencing token: a worker whose lease has passed to another can no longer write to the run.
"""

import time
from collections.abc import Collection
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Any

import structlog
from sqlalchemy import Select, String, cast, delete, func, literal, or_, select, update
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from seamark.server import workers
from seamark.server.accounts.permissions import GUESTS
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.tables import Run, Turn, User
from seamark.server.runs.columns import RunSpec
from seamark.server.runs.failure_reasons import FailureReason, describe
from seamark.server.runs.states import RunState, move
from seamark.server.settings import Settings

_log = structlog.get_logger()
_DAY_S = 86_400.0


class Claim(RunSpec):
    """The lease on one run, and what its evaluation needs."""

    run_id: int
    attempt: int
    worker: str
    lease_s: float
    program_sha256: str | None


class LeaseStatus(Enum):
    """Whether a claim is still valid."""

    HELD = auto()
    CANCELLED = auto()  # by the owner: stop, then store what was recorded
    LOST = auto()  # another worker has the run: stop and write nothing


@dataclass(frozen=True, slots=True)
class Recovery:
    """What became of the runs whose lease had expired."""

    requeued: list[int] = field(default_factory=list)
    failed: list[int] = field(default_factory=list)
    queued: int = 0  # length of the queue afterwards


def claim(
    session: Session, worker: str, *, languages: Collection[str], settings: Settings
) -> Claim | None:
    """Claim the queued run whose turn it is and that this worker can evaluate; None without one.

    1. Only owners below the limit of running runs; of each owner only the oldest queued run.
    2. Accounts come first, then guests, then baselines. Among these the owner with the fewest
       running runs, then the one whose last run started longest ago, then the oldest run.

    Parameters
    ----------
    languages
        Of the uploads that this worker can run; empty: built-in programs only.
    """
    acquire(session, AdvisoryLock.CLAIM)
    run_id = session.scalar(_next_in_turn(languages, settings.running_max))
    if run_id is None:
        return None
    now = time.time()
    run = session.get_one(Run, run_id)
    lease: dict[str, Any] = {
        "worker": worker,
        "started_at": now,
        "lease_until": now + settings.lease_s,
    }
    reset: dict[str, Any] = {"attempt": Run.attempt + 1, "progress": 0.0, "t_simulated": 0.0}
    if not move(session, run_id, RunState.QUEUED, RunState.RUNNING, **lease, **reset):
        return None  # cancelled, on PostgreSQL, between the two statements
    _record_turn(session, run.owner, now)
    session.refresh(run)
    return Claim.from_rows(run, run_id=run.id, lease_s=settings.lease_s)


def heartbeat(
    session: Session, claim: Claim, *, progress: float, t_simulated: float, isolation: str | None
) -> LeaseStatus:
    """Renew the lease, record the progress and return whether the claim is still valid."""
    renewed = (
        update(Run)
        .where(Run.id == claim.run_id, Run.attempt == claim.attempt)
        .where(Run.state == RunState.RUNNING)
        .values(
            lease_until=time.time() + claim.lease_s,
            progress=progress,
            t_simulated=t_simulated,
            isolation=isolation,
        )
    )
    if session.scalar(renewed.returning(Run.id)) is not None:
        return LeaseStatus.HELD
    return poll(session, claim)


def poll(session: Session, claim: Claim) -> LeaseStatus:
    """Return whether the claim is still valid, without a write: cheap enough to call often."""
    query = select(Run.state).where(Run.id == claim.run_id, Run.attempt == claim.attempt)
    state = session.scalar(query)
    if state == RunState.RUNNING:
        return LeaseStatus.HELD
    return LeaseStatus.CANCELLED if state == RunState.CANCELLED else LeaseStatus.LOST


def release(
    session: Session, claim: Claim, why: str, *, counts: bool, settings: Settings
) -> RunState | None:
    """Put a run back to its old position in the queue; None if the claim is no longer valid.

    With `counts` it is a failure of the platform: after `attempts_max` of them the run fails with
    `platform_error`, so that a run that breaks its workers does not do so for ever.
    """
    run = session.get(Run, claim.run_id)
    if run is None or run.attempt != claim.attempt or run.state != RunState.RUNNING:
        return None
    return _requeue_or_fail(session, run, why, counts=counts, settings=settings)


def recover(session: Session, settings: Settings) -> Recovery:
    """Requeue the runs whose lease has expired; the caller then sends the missing tickets."""
    acquire(session, AdvisoryLock.CLAIM)
    now = time.time()
    recovery = Recovery()
    expired = select(Run).where(Run.state == RunState.RUNNING, Run.lease_until < now)
    for run in session.scalars(expired.order_by(Run.id)).all():
        state = _requeue_or_fail(session, run, "the lease expired", counts=True, settings=settings)
        if state is not None:
            (recovery.requeued if state is RunState.QUEUED else recovery.failed).append(run.id)
    session.execute(delete(Turn).where(Turn.served_at < now - _DAY_S))
    workers.forget_dead(session)
    return Recovery(recovery.requeued, recovery.failed, length(session))


def length(session: Session) -> int:
    """Return how many runs are queued."""
    return session.scalar(select(func.count()).where(Run.state == RunState.QUEUED)) or 0


def _requeue_or_fail(
    session: Session, run: Run, why: str, *, counts: bool, settings: Settings
) -> RunState | None:
    failures = run.failures + int(counts)
    new = RunState.QUEUED
    values: dict[str, Any] = {"failures": failures, "worker": None, "lease_until": None}
    if failures < settings.attempts_max:
        values |= {"progress": 0.0, "t_simulated": 0.0}
    else:
        new = RunState.FAILED
        detail = describe(FailureReason.PLATFORM_ERROR) | {"t_reached": run.t_simulated}
        values |= {"cause": FailureReason.PLATFORM_ERROR, "detail": detail}
    if not move(session, run.id, RunState.RUNNING, new, fence=run.attempt, **values):
        return None
    if new is RunState.QUEUED:  # the owner's turn was lost: it does not wait for another one
        session.execute(delete(Turn).where(Turn.owner == run.owner))
    _log.warning(
        "run_released", run=run.id, attempt=run.attempt, failures=failures, why=why, state=new
    )
    return new


def _next_in_turn(languages: Collection[str], running_max: int) -> Select[int]:
    running = (
        select(Run.owner, func.count().label("n"))
        .where(Run.state == RunState.RUNNING)
        .group_by(Run.owner)
        .cte("running")
    )
    suitable = or_(Run.language.is_(None), Run.language.in_(sorted(languages)))
    first = (
        select(Run.owner, func.min(Run.id).label("id"))
        .where(Run.state == RunState.QUEUED, suitable)
        .group_by(Run.owner)
        .cte("first")
    )
    n = func.coalesce(running.c.n, 0)
    baseline = select(literal("user:") + cast(User.id, String)).where(User.is_baseline)
    is_baseline = first.c.owner.in_(baseline)
    is_guest = first.c.owner.startswith(GUESTS)
    busy = select(func.count()).where(running.c.owner.in_(baseline)).scalar_subquery()
    return (
        select(first.c.id)
        .outerjoin(running, running.c.owner == first.c.owner)
        .outerjoin(Turn, Turn.owner == first.c.owner)
        .where(n < running_max, or_(~is_baseline, busy < 1))
        .order_by(is_baseline, is_guest, n, func.coalesce(Turn.served_at, 0.0), first.c.id)
        .limit(1)
    )


def _record_turn(session: Session, owner: str, now: float) -> None:
    insert = postgresql.insert if session.get_bind().dialect.name == "postgresql" else sqlite.insert
    turn = insert(Turn).values(owner=owner, served_at=now)
    session.execute(
        turn.on_conflict_do_update(index_elements=[Turn.owner], set_={"served_at": now})
    )
