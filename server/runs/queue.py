"""The queue: who runs next, and what happens to runs whose worker fell silent.

A claim is a lease of some seconds. Its holder renews it; the attempt number is the fencing token
without which nothing of the run can be written.
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
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.tables import Run, Turn, User
from seamark.server.runs.failure_reasons import Cause, words
from seamark.server.runs.states import RunState, move
from seamark.server.settings import Settings

_log = structlog.get_logger()
_DAY_S = 86_400.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """The right to evaluate one run for a while, and what that needs."""

    run_id: int
    attempt: int
    worker: str
    lease_s: float
    owner: str
    benchmark: str
    kind: str
    config: dict[str, Any]
    seed: int | None
    trials: int
    controller: str
    program_sha256: str | None
    program_name: str | None
    language: str | None


class Beat(Enum):
    """The answer to a heartbeat."""

    CONTINUE = auto()
    CANCEL = auto()  # the owner cancelled: stop, then close the books
    LOST = auto()  # somebody else has the run: stop and write nothing


@dataclass(frozen=True, slots=True)
class SweepReport:
    """What a sweep did."""

    returned: list[int] = field(default_factory=list)
    given_up: list[int] = field(default_factory=list)
    queued: int = 0  # runs that wait now


def claim(
    session: Session, worker: str, *, languages: Collection[str], settings: Settings
) -> Claim | None:
    """Take the fairest queued run that this worker can evaluate; None if there is none.

    1. Only owners below the cap of running runs; of each only the run that waits longest.
    2. Baselines come last. Then who has fewest runs running, then who was served longest ago,
       then who came first.

    Parameters
    ----------
    languages
        Of the uploads that this worker may run; empty: built-in controllers only.
    """
    acquire(session, AdvisoryLock.CLAIM)
    run_id = session.scalar(_fairest(languages, settings.running_max))
    if run_id is None:
        return None
    now = time.time()
    run = session.get_one(Run, run_id)
    lease: dict[str, Any] = {
        "worker": worker,
        "started_at": now,
        "lease_until": now + settings.lease_s,
    }
    fresh: dict[str, Any] = {"attempt": Run.attempt + 1, "progress": 0.0, "t_simulated": 0.0}
    if not move(session, run_id, RunState.QUEUED, RunState.RUNNING, **lease, **fresh):
        return None  # cancelled, on PostgreSQL, between the two statements
    _serve(session, run.owner, now)
    session.refresh(run)
    return _claim(run, worker, settings)


def heartbeat(
    session: Session, claim: Claim, *, progress: float, t_simulated: float, isolation: str | None
) -> Beat:
    """Renew the lease and note the progress; the answer says whether to go on."""
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
        return Beat.CONTINUE
    return look(session, claim)


def look(session: Session, claim: Claim) -> Beat:
    """Return what a heartbeat would, without renewing the lease: cheap enough to ask often."""
    query = select(Run.state).where(Run.id == claim.run_id, Run.attempt == claim.attempt)
    state = session.scalar(query)
    if state == RunState.RUNNING:
        return Beat.CONTINUE
    return Beat.CANCEL if state == RunState.CANCELLED else Beat.LOST


def give_back(
    session: Session, claim: Claim, why: str, *, counts: bool, settings: Settings
) -> RunState | None:
    """Return a run to its old place in the line; None if it is no longer this worker's.

    With `counts` it was a failure of ours: after `attempts_max` of them the run fails with
    `platform_error`, so that a run that breaks its workers cannot do it for ever.
    """
    run = session.get(Run, claim.run_id)
    if run is None or run.attempt != claim.attempt or run.state != RunState.RUNNING:
        return None
    return _release(session, run, why, counts=counts, settings=settings)


def sweep(session: Session, settings: Settings) -> SweepReport:
    """Return the runs of dead workers to the line; the caller then tops up the tickets."""
    acquire(session, AdvisoryLock.CLAIM)
    now = time.time()
    report = SweepReport()
    expired = select(Run).where(Run.state == RunState.RUNNING, Run.lease_until < now)
    for run in session.scalars(expired.order_by(Run.id)).all():
        state = _release(session, run, "the worker fell silent", counts=True, settings=settings)
        if state is not None:
            (report.returned if state is RunState.QUEUED else report.given_up).append(run.id)
    session.execute(delete(Turn).where(Turn.served_at < now - _DAY_S))
    workers.forget_dead(session)
    return SweepReport(report.returned, report.given_up, waiting(session))


def waiting(session: Session) -> int:
    """Return how many runs are queued."""
    return session.scalar(select(func.count()).where(Run.state == RunState.QUEUED)) or 0


def _release(
    session: Session, run: Run, why: str, *, counts: bool, settings: Settings
) -> RunState | None:
    failures = run.failures + int(counts)
    new = RunState.QUEUED
    values: dict[str, Any] = {"failures": failures, "worker": None, "lease_until": None}
    if failures < settings.attempts_max:
        values |= {"progress": 0.0, "t_simulated": 0.0}
    else:
        new = RunState.FAILED
        detail = words(Cause.PLATFORM_ERROR) | {"t_reached": run.t_simulated}
        values |= {"cause": Cause.PLATFORM_ERROR, "detail": detail}
    if not move(session, run.id, RunState.RUNNING, new, fence=run.attempt, **values):
        return None
    if new is RunState.QUEUED:  # the turn was for nothing: its owner does not wait for another
        session.execute(delete(Turn).where(Turn.owner == run.owner))
    _log.warning("released", run=run.id, attempt=run.attempt, failures=failures, why=why, state=new)
    return new


def _fairest(languages: Collection[str], running_max: int) -> Select[int]:
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
    last = first.c.owner.in_(baseline)
    busy = select(func.count()).where(running.c.owner.in_(baseline)).scalar_subquery()
    return (
        select(first.c.id)
        .outerjoin(running, running.c.owner == first.c.owner)
        .outerjoin(Turn, Turn.owner == first.c.owner)
        .where(n < running_max, or_(~last, busy < 1))
        .order_by(last, n, func.coalesce(Turn.served_at, 0.0), first.c.id)
        .limit(1)
    )


def _serve(session: Session, owner: str, now: float) -> None:
    insert = postgresql.insert if session.get_bind().dialect.name == "postgresql" else sqlite.insert
    turn = insert(Turn).values(owner=owner, served_at=now)
    session.execute(
        turn.on_conflict_do_update(index_elements=[Turn.owner], set_={"served_at": now})
    )


def _claim(run: Run, worker: str, settings: Settings) -> Claim:
    return Claim(
        run_id=run.id,
        attempt=run.attempt,
        worker=worker,
        lease_s=settings.lease_s,
        owner=run.owner,
        benchmark=run.benchmark,
        kind=run.kind,
        config=run.config,
        seed=run.seed,
        trials=run.trials,
        controller=run.controller,
        program_sha256=run.program_sha256,
        program_name=run.program_name,
        language=run.language,
    )
