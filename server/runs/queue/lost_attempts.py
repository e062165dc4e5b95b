"""Runs whose attempt ended without a result go back to the queue, or fail after too many of them.

An attempt that ends without a result costs the run nothing if its worker was stopped. It fails with
`platform_error` when its evaluation has broken three times, or when it has lost its worker
or the room for its data `INTERRUPTIONS_MAX` times: by then it may be the run that takes them.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Any

import structlog
from sqlalchemy import ColumnElement, select
from sqlalchemy.orm import Session

from seamark.programs.failure_reasons import FailureReason, describe
from seamark.server.database.advisory_locks import AdvisoryLock, try_acquire
from seamark.server.database.engine import after_commit
from seamark.server.database.tables import IS_RUNNING, Run
from seamark.server.messaging import workers
from seamark.server.monitoring import meters
from seamark.server.runs.queue.queue import Claim, length
from seamark.server.runs.record import totals, turns
from seamark.server.runs.record.solutions import ROSBRIDGE
from seamark.server.runs.record.states import RunState, move
from seamark.server.settings import Settings

_log = structlog.get_logger()
# Generous: whatever kills a worker most likely has nothing to do with the runs that it has.
INTERRUPTIONS_MAX = 10
_DISCONNECTED = "The service lost the connection to the program. Connect it again."


class AttemptEnd(Enum):
    """Why an attempt ended without a result."""

    SHUTDOWN = auto()  # its worker was stopped
    WORKER_LOST = auto()  # its worker died or was silent
    EVALUATION_BROKE = auto()  # its simulator crashed or hung, or its program is gone
    STORAGE_FAILED = auto()  # the storage was away or full


_INTERRUPTIONS = (AttemptEnd.WORKER_LOST, AttemptEnd.STORAGE_FAILED)


@dataclass(frozen=True, slots=True)
class Recovery:
    """What became of the runs that had lost their workers."""

    requeued: list[int] = field(default_factory=list)
    failed: list[int] = field(default_factory=list)
    tickets: int = 0  # that the queue needs: whoever ends a run sends the next one


def release(
    session: Session, claim: Claim, end: AttemptEnd, *, settings: Settings
) -> RunState | None:
    """Put a run back to its old position in the queue, or fail it after too many such attempts.

    None if the claim is no longer valid.
    """
    run = session.get(Run, claim.run_id)
    if run is None or run.attempt != claim.attempt or run.state != RunState.RUNNING:
        return None
    return _requeue_or_fail(session, run, end, settings=settings)


def leases(session: Session) -> dict[int, float]:
    """Return the leases that are held: run -> their ends."""
    held = select(Run.id, Run.lease_until).where(IS_RUNNING)
    return {run_id: end for run_id, end in session.execute(held) if end is not None}


def recover(session: Session, abandoned: Mapping[int, float], settings: Settings) -> Recovery:
    """Requeue the runs whose leases are abandoned; the caller then sends the missing tickets."""
    runs = _locked(session, Run.id.in_(sorted(abandoned)))
    unrenewed = [run for run in runs if run.lease_until == abandoned[run.id]]
    return _release_lost(session, unrenewed, settings)


def tidy(session: Session) -> None:
    """Forget owners and workers who have gone, and count the runs that have ended."""
    turns.forget_idle(session)
    if try_acquire(session, AdvisoryLock.TOTALS):
        totals.count_ended(session)
    workers.forget_dead(session)


def recover_from(session: Session, worker: str, settings: Settings) -> Recovery:
    """Requeue the runs of a process of a worker that has ended, without waiting for their leases.

    Parameters
    ----------
    worker
        As the process named itself when it claimed them.
    """
    return _release_lost(session, _locked(session, IS_RUNNING & (Run.worker == worker)), settings)


def _locked(session: Session, which: ColumnElement[bool]) -> list[Run]:
    """Return runs, locked with the rows of their owners before any of them is moved.

    Without those that another process ends, or whose owner's row is kept by a process that may have
    vanished: a later recovery finds them.
    """
    query = select(Run).where(which).order_by(Run.id).with_for_update(skip_locked=True)
    runs = session.scalars(query).all()
    free = turns.lock_free(session, {run.owner for run in runs}) if runs else ()
    return [run for run in runs if run.owner in free]


def _release_lost(session: Session, runs: Iterable[Run], settings: Settings) -> Recovery:
    recovery = Recovery()
    for run in runs:
        state = _requeue_or_fail(session, run, AttemptEnd.WORKER_LOST, settings=settings)
        if state is not None:
            (recovery.requeued if state is RunState.QUEUED else recovery.failed).append(run.id)
    tickets = min(length(session), max(workers.slot_count(session), 1))
    return Recovery(recovery.requeued, recovery.failed, tickets)


def _requeue_or_fail(
    session: Session, run: Run, end: AttemptEnd, *, settings: Settings
) -> RunState | None:
    counts = {
        "failures": run.failures + (end is AttemptEnd.EVALUATION_BROKE),
        "interruptions": run.interruptions + (end in _INTERRUPTIONS),
    }
    # The program at the other end of a connection does not know that its run would start again.
    sentence = _DISCONNECTED if run.controller == ROSBRIDGE else ""
    repeats = counts["failures"] < settings.attempts_max
    repeats = repeats and counts["interruptions"] < INTERRUPTIONS_MAX and not sentence
    new = RunState.QUEUED if repeats else RunState.FAILED
    values: dict[str, Any] = {**counts, "worker": None, "lease_until": None}
    if repeats:
        values |= {"progress": 0.0, "t_simulated": 0.0}
    else:
        detail = describe(FailureReason.PLATFORM_ERROR, sentence=sentence)
        detail["t_reached"] = run.t_simulated
        values |= {"cause": FailureReason.PLATFORM_ERROR, "detail": detail}
    if not move(session, run.id, RunState.RUNNING, new, fence=run.attempt, **values):
        return None
    if new is RunState.QUEUED:  # the owner's turn was lost: it does not wait for another one
        turns.serve_first(session, run.owner)
    why = end.name.lower()
    after_commit(session, meters.ATTEMPTS_LOST.labels(why, new).inc)
    _log.warning("run_released", run=run.id, attempt=run.attempt, why=why, state=new, **counts)
    return new
