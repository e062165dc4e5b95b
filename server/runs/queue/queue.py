"""The queue: which run starts next, and the lease of the worker that has it.

A claim is a lease of a few seconds that its holder renews by heartbeats. The attempt number is the
fencing token: a worker whose lease has passed to another can no longer write to the run.
"""

import time
from collections import Counter
from collections.abc import Collection
from enum import Enum, auto
from functools import partial
from typing import Any

from sqlalchemy import Row, Select, func, select, update
from sqlalchemy.orm import Session

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
from seamark.server.runs.record import run_files, run_parts, turns
from seamark.server.runs.record.columns import OwnFile, RunSpec
from seamark.server.runs.record.states import RunState, move
from seamark.server.runs.record.turns import Priority, TurnKept
from seamark.server.settings import Settings

TURN_S = 3.0  # that a claim waits for an owner who is first in turn


class Claim(RunSpec):
    """The lease on one run, and what its evaluation needs."""

    run_id: int
    attempt: int
    worker: str
    lease_s: float
    program_sha256: str | None
    vehicle_sha256: str | None = None  # of a user's own
    files: tuple[OwnFile, ...] = ()  # further ones of a user's own
    user_id: int | None = None
    draw: int | None = None  # of fresh trials, if it verifies another run
    trial_seeds: tuple[int, ...] | None = None  # of a ranked run; None: not filled in yet
    request_id: str | None = None  # that queued the run, for the log


class LeaseStatus(Enum):
    """Whether a claim is still valid."""

    HELD = auto()
    CANCELLED = auto()  # by the owner: stop, then store what was recorded
    LOST = auto()  # another worker has the run: stop and write nothing


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
    *(getattr(Run, name) for name in Claim.model_fields if name in Run.__table__.columns),
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
    drained, code, slots, stored, guests = session.connection().execute(_SITUATION, bound).one()
    if drained or code not in (None, result_code()):
        return None
    passed_over, limit = int(stored or 0), _running_limit(slots or 0, settings)
    guests_first = passed_over >= order.GUEST_SHARE and try_acquire(
        session, AdvisoryLock.GUEST_TURN
    )
    next_run = next_in_turn.find(
        session, languages, limit, guests_first=guests_first, patient=patient
    )
    if next_run is None:
        return None
    run_id, priority = next_run
    run = _start(session, run_id, worker, settings)
    if run is None:  # only where the run was not locked, on SQLite, and there nobody else writes
        return None
    if run.attempt == 1:  # a repeated run has kept its time of submission
        waiting = meters.RUN_WAITING.labels(priority.label)
        after_commit(session, partial(waiting.observe, max(time.time() - run.queued_at, 0.0)))
    order.count_start(session, run.owner, run_id, before=passed_over, guests_wait=guests)
    return _claim_of(session, run, run_id, settings)


def start(session: Session, run_id: int, worker: str, settings: Settings) -> None:
    """Start a run that a worker has a slot for before anybody can see it in the queue."""
    _start(session, run_id, worker, settings)


def started(session: Session, run_id: int, worker: str, settings: Settings) -> Claim | None:
    """Return the claim of a worker on a run that was started for it; None if it has ended."""
    mine = (Run.id == run_id, Run.state == RunState.RUNNING, Run.worker == worker)
    columns = (Run.owner, Run.kind, *_CLAIMED)
    run = session.execute(select(*columns).where(*mine)).one_or_none()
    return None if run is None else _claim_of(session, run, run_id, settings)


def _start(session: Session, run_id: int, worker: str, settings: Settings) -> Row[Any] | None:
    now = time.time()
    lease: dict[str, Any] = {"started_at": now, "lease_until": now + settings.lease_s}
    reset: dict[str, Any] = {"progress": 0.0, "t_simulated": 0.0}
    start_run = partial(move, session, run_id, RunState.QUEUED, RunState.RUNNING)
    return start_run(returning=_CLAIMED, worker=worker, **lease, **reset)


def _claim_of(session: Session, run: Row[Any], run_id: int, settings: Settings) -> Claim:
    values = dict(run._mapping) | {"run_id": run_id, "lease_s": settings.lease_s}
    values["parts"] = tuple(run_parts.of_runs(session, [(run_id, run.benchmark)])[run_id])
    values["files"] = tuple(run_files.of_runs(session, [(run_id, run.config)])[run_id])
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


def busy_processes(session: Session) -> list[str]:
    """Return the names of the processes that have runs."""
    return [name for name in session.scalars(select(Run.worker).where(IS_RUNNING)) if name]


def length(session: Session) -> int:
    """Return how many runs are queued."""
    return session.scalar(select(func.count()).where(IS_QUEUED)) or 0


def neglected(session: Session, settings: Settings) -> float | None:
    """Return when the last run started, if runs wait that a worker with a free slot could start.

    None if all is as it should be: nothing waits, all slots are taken, their workers are drained
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

    It leaves a slot of the living workers to others: a run cannot be interrupted, so that whoever
    came while one owner had all slots would wait until the first of them ends.
    """
    return _running_limit(workers.slot_count(session), settings)


def _running_limit(slots: int, settings: Settings) -> int:
    return min(settings.running_max, max(slots - 1, 1)) if slots else settings.running_max
