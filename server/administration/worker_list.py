"""The workers with what each of them runs; draining."""

from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy.orm import Session

from seamark.server.accounts import audit
from seamark.server.accounts.audit import Actor, AuditAction
from seamark.server.administration import live_runs
from seamark.server.administration.live_runs import LiveRun
from seamark.server.messaging import workers
from seamark.server.messaging.workers import WorkerStatus


@dataclass(frozen=True, slots=True)
class ListedWorker:
    """A worker with its runs."""

    status: WorkerStatus
    runs: Sequence[LiveRun]


def listed(session: Session) -> list[ListedWorker]:
    """Return all workers that were seen in the last day, by name."""
    runs = dict[str, list[LiveRun]]()
    for run in live_runs.running(session):
        runs.setdefault(run.worker or "", []).append(run)
    return [ListedWorker(each, runs.get(each.name, ())) for each in workers.listed(session)]


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
