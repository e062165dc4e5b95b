"""The workers with what each of them runs; draining."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from seamark.server import audit, workers
from seamark.server.audit import Actor, AuditAction
from seamark.server.database.tables import IS_RUNNING, Run, User
from seamark.server.workers import WorkerStatus

RUNS_MAX = 1000  # running ones that are looked at


@dataclass(frozen=True, slots=True)
class RunningRun:
    """A run that a worker evaluates."""

    id: int
    user: str | None  # None: a guest
    benchmark: str
    progress: float
    started_at: float | None


@dataclass(frozen=True, slots=True)
class FleetWorker:
    """A worker with its runs."""

    status: WorkerStatus
    runs: Sequence[RunningRun]


def listed(session: Session) -> list[FleetWorker]:
    """Return all workers that were seen in the last day, by name."""
    runs = _running(session)
    return [FleetWorker(each, runs.get(each.name, ())) for each in workers.listed(session)]


def drain(session: Session, actor: Actor, name: str) -> bool:
    """Let a worker claim no more runs; False if that changes nothing."""
    changed = workers.drain(session, name)
    if changed:
        audit.record(session, actor, AuditAction.WORKER_DRAINED, name)
    return changed


def resume(session: Session, actor: Actor, name: str) -> bool:
    """Let a drained worker claim runs again; False if that changes nothing."""
    changed = workers.resume(session, name)
    if changed:
        audit.record(session, actor, AuditAction.WORKER_RESUMED, name)
    return changed


def _running(session: Session) -> Mapping[str, Sequence[RunningRun]]:
    """Return the running runs of each worker."""
    columns = (Run.id, Run.benchmark, Run.progress, Run.started_at, Run.worker, User.name)
    query = select(*columns).outerjoin(User, User.id == Run.user_id).where(IS_RUNNING)
    found = dict[str, list[RunningRun]]()
    for row in session.execute(query.order_by(Run.id).limit(RUNS_MAX)):
        run = RunningRun(row.id, row.name, row.benchmark, row.progress, row.started_at)
        found.setdefault(workers.worker_of(row.worker or ""), []).append(run)
    return found
