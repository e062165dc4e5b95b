"""The state of the service at a glance, and what needs a person."""

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy import and_, func, select
from sqlalchemy.orm import Session

from seamark.programs.failure_reasons import FailureReason
from seamark.server.accounts.audit import AuditAction
from seamark.server.database.operation_tables import AuditEntry
from seamark.server.database.tables import IS_LISTED, Run
from seamark.server.messaging import workers
from seamark.server.messaging.workers import WorkerStatus
from seamark.server.runs.leaderboard import reference_entries
from seamark.server.runs.record import totals
from seamark.server.runs.record.states import FINAL, RunState
from seamark.server.settings import Settings
from seamark.server.storage import storage

LONG_WAIT_S = 900.0  # of the oldest run in the queue: longer needs a look
_DAY_S = 86_400.0


@dataclass(frozen=True, slots=True)
class Alert:
    """Something that needs a person; `area` is the page on which to look."""

    sentence: str
    area: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Overview:
    """The figures of the first page of the administration."""

    queued: int
    running: int
    oldest_queued_at: float | None
    slots: int  # of workers that claim runs
    workers: Sequence[WorkerStatus]
    free_bytes: int
    ended: Mapping[RunState, int]  # in the last 24 h
    causes: Mapping[str, int]  # of failures in the last 24 h, the most frequent first
    warnings: Sequence[Alert]


def overview(session: Session, settings: Settings) -> Overview:
    """Return the state of the service."""
    counts, listed = totals.counts(session), workers.listed(session)
    oldest, causes = totals.oldest_queued_at(session), _causes(session)
    warnings = [
        *_about_workers(listed),
        *_about_storage(settings),
        *_about_runs(session, oldest, causes),
    ]
    return Overview(
        queued=counts[RunState.QUEUED],
        running=counts[RunState.RUNNING],
        oldest_queued_at=oldest,
        slots=workers.slot_count(session),
        workers=listed,
        free_bytes=storage.free_bytes(settings.data),
        ended=_ended(session),
        causes=causes,
        warnings=warnings,
    )


def _ended(session: Session) -> dict[RunState, int]:
    """Return how many runs ended in the last day, by state."""
    recent = and_(Run.finished_at > time.time() - _DAY_S, IS_LISTED)
    return {
        state: session.scalar(select(func.count()).where(recent, Run.state == state)) or 0
        for state in FINAL
    }


def _causes(session: Session) -> dict[str, int]:
    # Not by the state: SQLite would look at all runs that ever failed.
    recent = (Run.finished_at > time.time() - _DAY_S, Run.cause.is_not(None), IS_LISTED)
    count = func.count().label("count")
    query = select(Run.cause, count).where(*recent).group_by(Run.cause)
    return {str(cause): number for cause, number in session.execute(query.order_by(count.desc()))}


def _about_workers(listed: Sequence[WorkerStatus]) -> Iterator[Alert]:
    if not any(worker.claims for worker in listed):
        yield Alert("No worker starts runs: all are offline, drained or outdated.", "workers")
    for worker in listed:
        if why := _idle(worker):
            yield Alert(f"Worker {worker.name} is {why}.", "workers")
        for name, state in worker.broken_processes.items():
            yield Alert(f"Worker {worker.name}: its process {name} is {state}.", "workers")
        failed = sum(not finding.get("ok") for finding in worker.findings)
        if worker.alive and failed:
            checks = "1 isolation check fails" if failed == 1 else f"{failed} isolation checks fail"
            yield Alert(f"Worker {worker.name}: {checks}.", "workers")
    versions = {worker.version for worker in listed if worker.alive}
    if len(versions) > 1:
        yield Alert(f"Workers have different versions: {', '.join(sorted(versions))}.", "workers")


def _idle(worker: WorkerStatus) -> str | None:
    """Return why a worker starts no runs; None if it does."""
    if not worker.alive:
        return "offline"
    if worker.drained_at is not None:
        return "drained and starts no runs"
    return "outdated and starts no runs" if worker.outdated else None


def _about_storage(settings: Settings) -> Iterator[Alert]:
    if storage.is_away(settings):
        yield Alert("The data folder cannot be reached.", "disk")
    elif storage.refusal(settings):
        yield Alert("Too little disk space is free: new runs are refused.", "disk")


def _about_runs(
    session: Session, oldest: float | None, causes: Mapping[str, int]
) -> Iterator[Alert]:
    if oldest is not None and time.time() - oldest > LONG_WAIT_S:
        minutes = round((time.time() - oldest) / 60.0)
        yield Alert(f"The oldest queued run has been waiting for {minutes} minutes.", "queue")
    failures = causes.get(FailureReason.PLATFORM_ERROR, 0)
    if failures:
        what = "1 run" if failures == 1 else f"{failures} runs"
        yield Alert(f"{what} failed in the last 24 hours because of the service itself.", "runs")
    for title, _ in reference_entries.deviations(session):
        yield Alert(f"The reference entry {title} differs from the shipped result.", "status")
    blocked = (AuditEntry.action == AuditAction.SIGN_IN_BLOCKED,)
    recent = select(AuditEntry.id).where(*blocked, AuditEntry.at > time.time() - _DAY_S)
    if session.scalar(recent.order_by(AuditEntry.id.desc()).limit(1)) is not None:
        yield Alert("Sign-ins were blocked after too many wrong passwords.", "audit")
