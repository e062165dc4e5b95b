"""A run's place in the line, how long it will take, and why it waits."""

import time
from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from server.orders import ALIVE_S, upload_refusal
from server.settings import Settings
from server.states import RunState
from server.tables import Run, Worker

_RECENT = 20  # ended runs of the same sort from which a duration is estimated


@dataclass(frozen=True, slots=True)
class Wait:
    """What a live run has before it."""

    position: int | None
    estimate_s: float | None
    why: str | None


def wait_of(session: Session, run: Run, settings: Settings) -> Wait:
    """Return the place in the line of a queued run, and the time left of a live one."""
    typical = _typical_s(session, run)
    now = time.time()
    if run.state == RunState.RUNNING:
        return Wait(None, _left_s(run, now, typical), None)
    slots = session.scalar(select(func.sum(Worker.slots)).where(Worker.seen_at > now - ALIVE_S))
    position = _position(session, run)
    estimate = None
    if slots and typical is not None:
        estimate = typical * (1 + (position - 1) / slots)
    return Wait(position, estimate, _why(session, run, settings, slots=slots, ahead=position - 1))


def _position(session: Session, run: Run) -> int:
    """Return the place, 1 = next, in rounds: everybody's first run, then everybody's second ..."""
    running = (
        select(Run.owner, func.count().label("n"))
        .where(Run.state == RunState.RUNNING)
        .group_by(Run.owner)
        .cte("running")
    )
    turn = func.row_number().over(partition_by=Run.owner, order_by=Run.id)
    queued = (
        select(Run.id, (turn + func.coalesce(running.c.n, 0)).label("turn"))
        .outerjoin(running, running.c.owner == Run.owner)
        .where(Run.state == RunState.QUEUED)
        .cte("queued")
    )
    mine = select(queued.c.turn).where(queued.c.id == run.id).scalar_subquery()
    earlier = (queued.c.turn < mine) | ((queued.c.turn == mine) & (queued.c.id < run.id))
    return 1 + (session.scalar(select(func.count()).select_from(queued).where(earlier)) or 0)


def _typical_s(session: Session, run: Run) -> float | None:
    """Return how long such runs took lately, scaled by the number of trials."""
    recent = (
        select(((Run.finished_at - Run.started_at) / Run.trials).label("s"))
        .where(Run.benchmark == run.benchmark, Run.state == RunState.SUCCEEDED)
        .order_by(Run.id.desc())
        .limit(_RECENT)
        .subquery()
    )
    each = session.scalar(select(func.avg(recent.c.s)))
    return None if each is None else float(each) * run.trials


def _left_s(run: Run, now: float, typical: float | None) -> float | None:
    elapsed = now - (run.started_at or now)
    if run.progress > 0.05:  # before that its own pace says little
        return elapsed * (1.0 - run.progress) / run.progress
    return None if typical is None else max(typical - elapsed, 0.0)


def _why(session: Session, run: Run, settings: Settings, *, slots: int | None, ahead: int) -> str:
    if not slots:
        return "No worker is running. The run starts as soon as one is there."
    if run.language is not None and (refusal := upload_refusal(session, run.language, settings)):
        return refusal
    mine = (Run.owner == run.owner) & (Run.state == RunState.RUNNING)
    running = session.scalar(select(func.count()).where(mine)) or 0
    if running >= settings.running_max:
        return f"{running} of your runs are running, which is the most at a time."
    if ahead == 0:
        return "It is next: it starts as soon as a worker is free."
    return f"{ahead} run{'s are' if ahead > 1 else ' is'} before it, taken in turns between users."
