"""The runs that wait and those that are evaluated, for admins."""

from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import ColumnElement, select
from sqlalchemy.orm import Session

from seamark.server.database.tables import IS_RUNNING, Run, User
from seamark.server.messaging import workers
from seamark.server.runs.queue import queue, start_order

WAITING_MAX = 200  # runs that are listed
RUNNING_MAX = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveRun:
    """A run that waits or is evaluated."""

    id: int
    user: str | None  # None: a guest
    benchmark: str
    kind: str
    controller: str
    program_name: str | None
    language: str | None  # of an uploaded program
    expected_s: float | None  # wall time of its evaluation
    queued_at: float
    started_at: float | None
    progress: float
    attempt: int
    rejudges: int | None  # the run that a rejudgement computes again
    worker: str | None


@dataclass(frozen=True, slots=True)
class Queue:
    """The queue: how many runs wait, those that start next, and those that are evaluated."""

    length: int
    waiting: Sequence[LiveRun]
    running: Sequence[LiveRun]


def listed(session: Session) -> Queue:
    """Return the queue, the first `WAITING_MAX` runs in the order in which they will start."""
    order = start_order.first(session, WAITING_MAX)
    waiting = {run.id: run for run in _runs(session, Run.id.in_(order))}
    return Queue(
        length=queue.length(session),
        waiting=[waiting[run_id] for run_id in order if run_id in waiting],
        running=running(session),
    )


def running(session: Session) -> Sequence[LiveRun]:
    """Return the runs that are evaluated, the oldest first."""
    return _runs(session, IS_RUNNING)


def _runs(session: Session, condition: ColumnElement[bool]) -> list[LiveRun]:
    copied = [name for name in LiveRun.__dataclass_fields__ if name not in ("user", "worker")]
    columns = (*(getattr(Run, name) for name in copied), Run.worker, User.name.label("user"))
    query = select(*columns).outerjoin(User, User.id == Run.user_id).where(condition)
    rows = session.execute(query.order_by(Run.id).limit(RUNNING_MAX)).mappings()
    return [LiveRun(**{**row, "worker": _worker(row["worker"])}) for row in rows]


def _worker(process: str | None) -> str | None:
    return None if process is None else workers.worker_of(process)
