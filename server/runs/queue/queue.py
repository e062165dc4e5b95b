"""The queue: which run starts next, and what happens to runs whose worker died.

A claim is a lease of a few seconds that its holder renews by heartbeats. The attempt number is the
fencing token: a worker whose lease has passed to another can no longer write to the run.

An attempt that ends without a result costs the run nothing if its worker was stopped. It fails with
`platform_error` when its evaluation has broken `attempts_max` times, or when it has lost its worker
or the room for its data `INTERRUPTIONS_MAX` times: by then it may be the run that takes them.
"""

import time
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto
from functools import partial
from typing import Any

import structlog
from sqlalchemy import ColumnElement, Row, Select, func, select, update
from sqlalchemy.orm import Session

from seamark.programs.failure_reasons import FailureReason, describe
from seamark.server.database import data_folder
from seamark.server.database.advisory_locks import AdvisoryLock, try_acquire
from seamark.server.database.engine import Database, after_commit
from seamark.server.database.queue_tables import Turn
from seamark.server.database.result_code import result_code
from seamark.server.database.tables import IS_QUEUED, IS_RUNNING, Run
from seamark.server.messaging import workers
from seamark.server.monitoring import meters
from seamark.server.runs.queue import next_in_turn, order
from seamark.server.runs.queue.next_in_turn import TurnTaken
from seamark.server.runs.record import totals, turns
from seamark.server.runs.record.columns import RunSpec
from seamark.server.runs.record.solutions import ROSBRIDGE
from seamark.server.runs.record.states import RunState, move
from seamark.server.runs.record.turns import Priority, TurnKept
from seamark.server.settings import Settings

_log = structlog.get_logger()
# Generous: whatever kills a worker most likely has nothing to do with the runs that it has.
INTERRUPTIONS_MAX = 10
_DISCONNECTED = "The service lost the connection to the program. Connect it again."
TURN_S = 3.0  # that a claim waits for an owner who is first in turn


class Claim(RunSpec):
    """The lease on one run, and what its evaluation needs."""

    run_id: int
    attempt: int
    worker: str
    lease_s: float
    program_sha256: str | None
    user_id: int | None = None
    draw: int | None = None  # of fresh water, if it verifies another run
    trial_seeds: tuple[int, ...] | None = None  # of a ranked run; None: not filled in yet
    request_id: str | None = None  # that queued the run, for the log


class LeaseStatus(Enum):
    """Whether a claim is still valid."""

    HELD = auto()
    CANCELLED = auto()  # by the owner: stop, then store what was recorded
    LOST = auto()  # another worker has the run: stop and write nothing


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


def _situation() -> Select[bool, str | None, int | None, float, bool]:
    guests_wait = select(Turn.owner).where(turns.IS_WAITING, Turn.priority == int(Priority.GUEST))
    return select(
        workers.drained(),
        data_folder.CURRENT_CODE,
        workers.slots(),
        order.stored_passed_over(),
        guests_wait.exists(),
    )


# What is asked at each claim, built once: building it takes longer than the database with it.
_SITUATION = _situation()
_CLAIMED = (
    Run.queued_at,
    *(getattr(Run, name) for name in Claim.model_fields if hasattr(Run, name)),
)


def claim(
    database: Database, worker: str, *, languages: Collection[str], settings: Settings
) -> Claim | None:
    """Claim the queued run whose turn it is and that this worker can evaluate; None without one.

    Only owners below the limit of running runs have their turn, in the order of `order`; of each
    owner only the oldest queued run starts.

    A drained worker gets none, nor does one that would compute something else than the version
    to which the database was upgraded last.

    Claims at the same time have the order of some claims one after the other, unless a transaction
    keeps the row of an owner for longer than `TURN_S`: then the others do not wait for it.

    Parameters
    ----------
    languages
        Of the uploads that this worker can run; empty: built-in programs only.
    """
    until, awaited = time.monotonic() + TURN_S, ""
    while True:
        left_s = until - time.monotonic()
        try:
            with database.writing() as session:
                if awaited:
                    turns.wait_for(session, awaited, within_s=left_s)
                return try_claim(
                    session, worker, languages=languages, settings=settings, patient=left_s > 0
                )
        except TurnTaken as taken:
            awaited = taken.owner
        except TurnKept:
            until, awaited = 0.0, ""


def try_claim(
    session: Session,
    worker: str,
    *,
    languages: Collection[str],
    settings: Settings,
    patient: bool = False,
) -> Claim | None:
    """Claim a run as `claim` does, in a transaction that the caller has begun.

    Parameters
    ----------
    patient
        Raise TurnTaken rather than pass over an owner who is in turn.
    """
    bound = workers.bound(worker)
    drained, code, places, stored, guests = session.connection().execute(_SITUATION, bound).one()
    if drained or code not in (None, result_code()):
        return None
    passed_over, limit = int(stored or 0), _running_limit(places or 0, settings)
    guests_first = passed_over >= order.GUEST_SHARE and try_acquire(
        session, AdvisoryLock.GUEST_TURN
    )
    found = next_in_turn.find(session, languages, limit, guests_first=guests_first, patient=patient)
    if found is None:
        return None
    run_id, priority = found
    run = _start(session, run_id, worker, settings)
    if run is None:  # only where the run was not locked, on SQLite, and there nobody else writes
        return None
    if run.attempt == 1:  # a repeated run has kept its time of submission
        waiting = meters.RUN_WAITING.labels(priority.label)
        after_commit(session, partial(waiting.observe, max(time.time() - run.queued_at, 0.0)))
    order.count_start(session, run.owner, run_id, before=passed_over, guests_wait=guests)
    return _claim_of(run, run_id, settings)


def start(session: Session, run_id: int, worker: str, settings: Settings) -> None:
    """Start a run that a worker has a place for before anybody can see it in the queue."""
    _start(session, run_id, worker, settings)


def started(session: Session, run_id: int, worker: str, settings: Settings) -> Claim | None:
    """Return the claim of a worker on a run that was started for it; None if it has ended."""
    mine = (Run.id == run_id, Run.state == RunState.RUNNING, Run.worker == worker)
    columns = (Run.owner, Run.kind, *_CLAIMED)
    run = session.execute(select(*columns).where(*mine)).one_or_none()
    return None if run is None else _claim_of(run, run_id, settings)


def _start(session: Session, run_id: int, worker: str, settings: Settings) -> Row[Any] | None:
    now = time.time()
    lease: dict[str, Any] = {"started_at": now, "lease_until": now + settings.lease_s}
    reset: dict[str, Any] = {"progress": 0.0, "t_simulated": 0.0}
    start_run = partial(move, session, run_id, RunState.QUEUED, RunState.RUNNING)
    return start_run(returning=_CLAIMED, worker=worker, **lease, **reset)


def _claim_of(run: Row[Any], run_id: int, settings: Settings) -> Claim:
    values = dict(run._mapping) | {"run_id": run_id, "lease_s": settings.lease_s}
    return Claim.model_validate(values)


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


def busy_processes(session: Session) -> list[str]:
    """Return the names of the processes that have runs."""
    return [name for name in session.scalars(select(Run.worker).where(IS_RUNNING)) if name]


def recover(session: Session, abandoned: Mapping[int, float], settings: Settings) -> Recovery:
    """Requeue the runs whose leases are abandoned; the caller then sends the missing tickets."""
    found = _locked(session, Run.id.in_(sorted(abandoned)))
    unrenewed = [run for run in found if run.lease_until == abandoned[run.id]]
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


def length(session: Session) -> int:
    """Return how many runs are queued."""
    return session.scalar(select(func.count()).where(IS_QUEUED)) or 0


def neglected(session: Session, settings: Settings) -> float | None:
    """Return when the last run started, if runs wait that a worker with a free place could start.

    None if all is as it should be: nothing waits, all places are taken, their workers are drained
    or prepare, or run no such programs, or all owners have as many running runs as they may.
    """
    busy = Counter(map(workers.worker_of, busy_processes(session)))
    ready = [each for each in workers.listed(session) if each.claims and not each.preparing]
    free = [worker for worker in ready if busy[worker.name] < worker.slots]
    languages = {language for worker in free for language in worker.languages}
    limit = running_limit(session, settings)
    if not free or not next_in_turn.may_start(session, languages, limit):
        return None
    return session.scalar(select(func.max(Turn.served_at))) or 0.0


def running_limit(session: Session, settings: Settings) -> int:
    """Return how many runs of one owner may run at the same time.

    It leaves a place of the living workers to others: a run cannot be interrupted, so that whoever
    came while one owner had all places would wait until the first of them ends.
    """
    return _running_limit(workers.slot_count(session), settings)


def _running_limit(places: int, settings: Settings) -> int:
    return min(settings.running_max, max(places - 1, 1)) if places else settings.running_max


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
