"""The queue of checks: two simulated seconds of a program before it is submitted.

Checks are not rows of `runs`: they appear in no list, count towards no quota, expire after an hour
and must not wait behind runs that take minutes. States: queued -> running -> done. As for runs, a
claim is a lease that its holder renews, with the attempt as fencing token.
"""

import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeVar

import structlog
from redis import Redis
from redis.exceptions import RedisError
from sqlalchemy import ColumnElement, Select, delete, func, select, update
from sqlalchemy.orm import Session

from seamark.programs.check_report import platform_failure
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.competition_tables import Competition, CompetitionFile
from seamark.server.database.tables import Check, Run, RunFile, RunPart
from seamark.server.messaging import workers
from seamark.server.programs.store import StoredProgram
from seamark.server.programs.vehicles import StoredVehicle

WAKE_UP_KEY = "seamark:checks"  # a list in the broker; its items have no meaning
WAKE_UPS_MAX = 100
ATTEMPTS_MAX = 2  # the second one that breaks is reported
CLAIMS_MAX = 6  # among them those of workers that were stopped or died
WAITING_MAX = 20
SEEN = "seen"  # of a report: what the images of a detector are rendered from
DONE_KEPT_S = 3600.0  # until a finished check is deleted
QUEUED_KEPT_S = 600.0  # until a check that no worker claimed is deleted
_log = structlog.get_logger()
_Selected = TypeVar("_Selected", Check, int)


class CheckState(StrEnum):
    """The state of a check."""

    QUEUED = "queued"
    RUNNING = "running"
    DONE = "done"


class CheckRefused(Exception):
    """Too many checks. The text is for the user, `retry_after_s` for the API."""

    def __init__(self, sentence: str, *, retry_after_s: int) -> None:
        super().__init__(sentence)
        self.retry_after_s = retry_after_s


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckClaim:
    """A worker's lease on a check, with what it needs to run it."""

    check_id: int
    attempt: int
    lease_s: float
    benchmark: str
    config: dict[str, Any]
    program_sha256: str
    program_name: str
    language: str
    vehicle_sha256: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckView:
    """A check as its owner sees it."""

    id: int
    state: CheckState
    benchmark: str
    config: dict[str, Any]
    program_name: str
    language: str
    report: dict[str, Any] | None  # see seamark.programs.check_report


def enqueue(
    session: Session,
    user_id: int,
    benchmark: str,
    config: dict[str, Any],
    program: StoredProgram,
    vehicle: StoredVehicle | None = None,
) -> int:
    """Insert a check and return its id. The caller commits, then calls `wake_worker`.

    It replaces a check of the same user that is still queued.

    Raises
    ------
    CheckRefused
        The user's previous check is running, or the queue is full.
    """
    acquire(session, AdvisoryLock.CHECKS)
    mine = Check.user_id == user_id
    session.execute(delete(Check).where(mine, Check.state == CheckState.QUEUED))
    running = (Check.state == CheckState.RUNNING) & (Check.lease_until > time.time())
    if session.scalar(select(Check.id).where(mine, running)) is not None:
        raise CheckRefused("Your previous check is still running.", retry_after_s=2)
    waiting = select(func.count()).where(Check.state == CheckState.QUEUED)
    if (session.scalar(waiting) or 0) >= WAITING_MAX:
        raise CheckRefused("The queue of checks is full; try again soon.", retry_after_s=10)
    check = Check(
        user_id=user_id,
        benchmark=benchmark,
        config=config,
        program_sha256=program.sha256,
        vehicle_sha256=None if vehicle is None else vehicle.sha256,
        program_name=program.name,
        language=program.language,
        state=CheckState.QUEUED,
        queued_at=time.time(),
    )
    session.add(check)
    session.flush()
    return check.id


def counts(session: Session) -> dict[CheckState, int]:
    """Return how many checks there are in each state; of those that are done, of the last hour."""
    query = select(Check.state, func.count()).group_by(Check.state)
    rows = {state: count for state, count in session.execute(query)}
    return {state: rows.get(state, 0) for state in CheckState}


def wake_worker(redis: Redis) -> None:
    """Wake up a worker; without the broker, workers find the check by polling."""
    try:
        redis.rpush(WAKE_UP_KEY, 1)
        redis.ltrim(WAKE_UP_KEY, -WAKE_UPS_MAX, -1)
    except RedisError as error:
        _log.warning("check_wake_up_failed", error=str(error))


def waiting(session: Session, *, languages: Collection[str]) -> bool:
    """Return whether there is a check to claim."""
    suitable = Check.language.in_(sorted(languages))
    query = select(Check.id).where(Check.state == CheckState.QUEUED, suitable).limit(1)
    return session.scalar(query) is not None


def claim(
    session: Session, worker: str, *, languages: Collection[str], lease_s: float
) -> CheckClaim | None:
    """Claim the oldest check. This is fair, since each user has at most one.

    A drained worker gets none.
    """
    if workers.is_drained(session, worker):
        return None
    suitable = Check.language.in_(sorted(languages))
    query = select(Check).where(Check.state == CheckState.QUEUED, suitable).order_by(Check.id)
    # One that another worker claims just now, or has vanished with, is passed over.
    check = session.scalar(query.limit(1).with_for_update(skip_locked=True))
    if check is None:
        return None
    check.state, check.attempt = CheckState.RUNNING, check.attempt + 1
    check.worker, check.lease_until = worker, time.time() + lease_s
    session.flush()
    return CheckClaim(
        check_id=check.id,
        attempt=check.attempt,
        lease_s=lease_s,
        benchmark=check.benchmark,
        config=check.config,
        program_sha256=check.program_sha256,
        program_name=check.program_name,
        language=check.language,
        vehicle_sha256=check.vehicle_sha256,
    )


def renew(session: Session, claim: CheckClaim) -> bool:
    """Renew the lease; False if this worker no longer holds it."""
    values = {"lease_until": time.time() + claim.lease_s}
    return _move(session, claim.check_id, claim.attempt, values)


def finish(session: Session, claim: CheckClaim, report: dict[str, Any]) -> bool:
    """Store the report; False if this worker no longer holds the lease."""
    values = _done(report)
    return _move(session, claim.check_id, claim.attempt, values)


def release(session: Session, check_id: int, attempt: int, *, attempts_max: int) -> None:
    """Requeue a check after a failure of the service; report the failure after the last attempt."""
    values: dict[str, Any] = {"state": CheckState.QUEUED, "worker": None, "lease_until": None}
    if attempt >= attempts_max:
        values = _done(platform_failure())
    _move(session, check_id, attempt, values)


def leases(session: Session) -> dict[int, float]:
    """Return the leases that are held: check -> their ends."""
    held = select(Check.id, Check.lease_until).where(Check.state == CheckState.RUNNING)
    return {check_id: end for check_id, end in session.execute(held) if end is not None}


def recover_from(session: Session, worker: str) -> None:
    """Release the checks of a process of a worker that has ended."""
    left = (Check.state == CheckState.RUNNING) & (Check.worker == worker)
    for check in session.scalars(_free(select(Check), left)).all():
        release(session, check.id, check.attempt, attempts_max=CLAIMS_MAX)


def recover(session: Session, abandoned: Mapping[int, float]) -> None:
    """Release the checks whose leases are abandoned, and delete old ones."""
    now = time.time()
    for check in session.scalars(_free(select(Check), Check.id.in_(sorted(abandoned)))).all():
        if check.lease_until == abandoned[check.id]:
            release(session, check.id, check.attempt, attempts_max=CLAIMS_MAX)
    stale = (Check.state == CheckState.QUEUED) & (Check.queued_at < now - QUEUED_KEPT_S)
    for old in (Check.finished_at < now - DONE_KEPT_S, stale):
        session.execute(
            delete(Check).where(Check.id.in_(_free(select(Check.id), old))),
            execution_options={"synchronize_session": False},
        )


def refers_to(session: Session, sha256: str) -> bool:
    """Return whether a check, a competition or a run that has its data uses this upload."""
    has_data = Run.data_deleted_at.is_(None)
    users = (
        select(Run.id).where(Run.program_sha256 == sha256, has_data),
        select(Run.id).where(Run.vehicle_sha256 == sha256, has_data),
        select(RunPart.run_id).join(Run).where(RunPart.program_sha256 == sha256, has_data),
        select(Check.id).where(Check.program_sha256 == sha256),
        select(Check.id).where(Check.vehicle_sha256 == sha256),
        select(Competition.id).where(Competition.vehicle_sha256 == sha256),
        select(RunFile.run_id).join(Run).where(RunFile.sha256 == sha256, has_data),
        select(CompetitionFile.competition_id).where(CompetitionFile.sha256 == sha256),
    )
    return any(session.scalar(query.limit(1)) is not None for query in users)


def show(session: Session, check_id: int, user_id: int) -> CheckView | None:
    """Return one of the user's checks; None if there is no such check."""
    check = session.get(Check, check_id)
    if check is None or check.user_id != user_id:
        return None
    return CheckView(
        id=check.id,
        state=CheckState(check.state),
        benchmark=check.benchmark,
        config=check.config,
        program_name=check.program_name,
        language=check.language,
        report=check.answer,
    )


def _free(query: Select[_Selected], which: ColumnElement[bool]) -> Select[_Selected]:
    """Lock what a query selects, without what another transaction has locked."""
    return query.where(which).order_by(Check.id).with_for_update(skip_locked=True)


def _done(report: dict[str, Any]) -> dict[str, Any]:
    return {"state": CheckState.DONE, "answer": report, "finished_at": time.time()}


def _move(session: Session, check_id: int, attempt: int, values: dict[str, Any]) -> bool:
    """Update a running check, but only as the holder of this attempt."""
    change = (
        update(Check)
        .where(Check.id == check_id, Check.attempt == attempt)
        .where(Check.state == CheckState.RUNNING)
        .values(**values)
    )
    return session.scalar(change.returning(Check.id)) is not None
