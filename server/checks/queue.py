"""Checks: two simulated seconds of a program before it is submitted. A queue of its own.

Not rows of `runs`: a check is in no list, no quota and no rank, lives for an hour, and must not
wait behind runs that take minutes. Its states are queued -> running -> done; a claim is a lease
with the attempt as fencing token, as for runs.
"""

import time
from collections.abc import Collection
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import structlog
from redis import Redis
from redis.exceptions import RedisError
from sqlalchemy import delete, func, select, update
from sqlalchemy.orm import Session

from seamark.server.checks import report
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.tables import Check, Run
from seamark.server.programs.store import StoredProgram

BELL = "seamark:checks"  # a list in the broker; what is in it says nothing
BELL_MAX = 100
LEASE_S = 150.0  # longer than any check may take, so that it needs no heartbeat
ATTEMPTS_MAX = 2
WAITING_MAX = 20
KEPT_S, STALE_S = 3600.0, 600.0  # a check that is done; one for which no worker came
SEED = 1  # of the water and noise: the same for all, so that a check can be repeated
_log = structlog.get_logger()


class CheckState(StrEnum):
    """Where a check is."""

    QUEUED = "queued"
    RUNNING = "running"
    DONE = "done"


class CheckRefused(Exception):
    """Too many checks. The text is for who asked; `retry_after_s` for the API."""

    def __init__(self, sentence: str, *, retry_after_s: int) -> None:
        super().__init__(sentence)
        self.retry_after_s = retry_after_s


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckClaim:
    """The right to carry out one check, and what that needs."""

    check_id: int
    attempt: int
    benchmark: str
    config: dict[str, Any]
    program_sha256: str
    program_name: str
    language: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckView:
    """A check as its owner sees it."""

    id: int
    state: CheckState
    benchmark: str
    program_name: str
    language: str
    answer: dict[str, Any] | None


def order(
    session: Session,
    user_id: int,
    benchmark: str,
    config: dict[str, Any],
    program: StoredProgram,
) -> int:
    """Insert a check and return its id. The caller commits, then calls `ring`.

    One that the same user still has waiting is replaced by it.

    Raises
    ------
    CheckRefused
        The user's last check is being carried out, or too many wait.
    """
    acquire(session, AdvisoryLock.CHECKS)
    mine = Check.user_id == user_id
    session.execute(delete(Check).where(mine, Check.state == CheckState.QUEUED))
    running = (Check.state == CheckState.RUNNING) & (Check.lease_until > time.time())
    if session.scalar(select(Check.id).where(mine, running)) is not None:
        raise CheckRefused("Your last check has not ended yet.", retry_after_s=2)
    waiting = select(func.count()).where(Check.state == CheckState.QUEUED)
    if (session.scalar(waiting) or 0) >= WAITING_MAX:
        raise CheckRefused("Many checks are waiting; try again soon.", retry_after_s=10)
    check = Check(
        user_id=user_id,
        benchmark=benchmark,
        config=config,
        program_sha256=program.sha256,
        program_name=program.name,
        language=program.language,
        state=CheckState.QUEUED,
        queued_at=time.time(),
    )
    session.add(check)
    session.flush()
    return check.id


def ring(redis: "Redis") -> None:
    """Wake a worker up; if the broker is away it will look by itself."""
    try:
        redis.rpush(BELL, 1)
        redis.ltrim(BELL, -BELL_MAX, -1)
    except RedisError as error:
        _log.warning("check_bell_failed", error=str(error))


def waiting(session: Session, *, languages: Collection[str]) -> bool:
    """Return whether there is a check to be claimed."""
    suitable = Check.language.in_(sorted(languages))
    query = select(Check.id).where(Check.state == CheckState.QUEUED, suitable).limit(1)
    return session.scalar(query) is not None


def claim(session: Session, *, languages: Collection[str]) -> CheckClaim | None:
    """Take the check that waits longest; nobody has more than one, so that this is fair."""
    acquire(session, AdvisoryLock.CHECKS)
    suitable = Check.language.in_(sorted(languages))
    query = select(Check).where(Check.state == CheckState.QUEUED, suitable).order_by(Check.id)
    check = session.scalar(query.limit(1))
    if check is None:
        return None
    check.state, check.attempt = CheckState.RUNNING, check.attempt + 1
    check.lease_until = time.time() + LEASE_S
    session.flush()
    return CheckClaim(
        check_id=check.id,
        attempt=check.attempt,
        benchmark=check.benchmark,
        config=check.config,
        program_sha256=check.program_sha256,
        program_name=check.program_name,
        language=check.language,
    )


def finish(session: Session, claim: CheckClaim, answer: dict[str, Any]) -> bool:
    """Store the answer; False if the check is no longer this worker's."""
    values = {"state": CheckState.DONE, "answer": answer, "finished_at": time.time()}
    return _move(session, claim.check_id, claim.attempt, values)


def give_back(session: Session, check_id: int, attempt: int) -> None:
    """Let a check that we broke be tried again, or say that it is our failure."""
    values: dict[str, Any] = {"state": CheckState.QUEUED, "lease_until": None}
    if attempt >= ATTEMPTS_MAX:
        answer = report.our_failure()
        values = {"state": CheckState.DONE, "answer": answer, "finished_at": time.time()}
    _move(session, check_id, attempt, values)


def sweep(session: Session) -> None:
    """Return the checks of dead workers to the line, and forget the old ones."""
    acquire(session, AdvisoryLock.CHECKS)
    now = time.time()
    lost = select(Check).where(Check.state == CheckState.RUNNING, Check.lease_until < now)
    for check in session.scalars(lost).all():
        give_back(session, check.id, check.attempt)
    session.execute(delete(Check).where(Check.finished_at < now - KEPT_S))
    stale = (Check.state == CheckState.QUEUED) & (Check.queued_at < now - STALE_S)
    session.execute(delete(Check).where(stale))


def refers_to(session: Session, sha256: str) -> bool:
    """Return whether a run or a check needs the program with this key."""
    run = select(Run.id).where(Run.program_sha256 == sha256).limit(1)
    check = select(Check.id).where(Check.program_sha256 == sha256).limit(1)
    return session.scalar(run) is not None or session.scalar(check) is not None


def show(session: Session, check_id: int, user_id: int) -> CheckView | None:
    """Return one of the user's checks; None if there is no such one."""
    check = session.get(Check, check_id)
    if check is None or check.user_id != user_id:
        return None
    return CheckView(
        id=check.id,
        state=CheckState(check.state),
        benchmark=check.benchmark,
        program_name=check.program_name,
        language=check.language,
        answer=check.answer,
    )


def _move(session: Session, check_id: int, attempt: int, values: dict[str, Any]) -> bool:
    """Change a running check, as the holder of this attempt only."""
    change = (
        update(Check)
        .where(Check.id == check_id, Check.attempt == attempt)
        .where(Check.state == CheckState.RUNNING)
        .values(**values)
    )
    return session.scalar(change.returning(Check.id)) is not None
