"""A run's place in the line, how long it will take, and why it waits."""

import time
from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from seamark.server import workers
from seamark.server.database.tables import Run, Turn, User
from seamark.server.runs.states import RunState
from seamark.server.settings import Settings

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
    slots = workers.slot_count(session)
    position = _position(session, run)
    if position is None:
        return Wait(None, typical, None)
    estimate = None
    if slots and typical is not None:
        estimate = typical * (1 + (position - 1) / slots)
    return Wait(position, estimate, _why(session, run, settings, slots=slots, ahead=position - 1))


def _position(session: Session, run: Run) -> int | None:
    """Return the place, 1 = next, in rounds: everybody's first run, then everybody's second ...

    From one row per owner, so that a long line costs no more than a short one. None if a worker
    took the run after it was read, which PostgreSQL shows to a transaction that writes.
    """
    owners = _owners(session)
    mine = owners.get(run.owner)
    if mine is None:
        return None
    own = (Run.owner == run.owner) & (Run.state == RunState.QUEUED)
    before = session.scalar(select(func.count()).where(own, Run.id < run.id)) or 0
    others = (other for name, other in owners.items() if name != run.owner)
    return 1 + before + sum(other.ahead_of(mine, before) for other in others)


@dataclass(frozen=True, slots=True)
class _Owner:
    """What one owner has in the line."""

    queued: int
    first: int  # id of the run that is next
    running: int
    served_at: float
    is_baseline: bool

    def ahead_of(self, mine: "_Owner", before: int) -> int:
        """Return how many of its runs start before the owner `mine` has started `before + 1`."""
        if self.is_baseline != mine.is_baseline:
            return 0 if self.is_baseline else self.queued
        rounds = mine.running + before - self.running
        turn = (self.served_at, self.first) < (mine.served_at, mine.first)
        return min(max(rounds + int(turn), 0), self.queued)


def _owners(session: Session) -> dict[str, _Owner]:
    """Return all owners with queued runs."""
    state = select(Run.owner, func.count()).group_by(Run.owner)
    running = {owner: n for owner, n in session.execute(state.where(Run.state == RunState.RUNNING))}
    names = session.scalars(select(User.id).where(User.is_baseline))
    baselines = {f"user:{user_id}" for user_id in names}
    queued = (
        select(Run.owner, func.count(), func.min(Run.id), func.coalesce(Turn.served_at, 0.0))
        .outerjoin(Turn, Turn.owner == Run.owner)
        .where(Run.state == RunState.QUEUED)
        .group_by(Run.owner, Turn.served_at)
    )
    return {
        owner: _Owner(n, first, running.get(owner, 0), served_at, owner in baselines)
        for owner, n, first, served_at in session.execute(queued)
    }


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


def _why(session: Session, run: Run, settings: Settings, *, slots: int, ahead: int) -> str:
    if not slots:
        return "No worker is running. The run starts as soon as one is there."
    if run.language is not None and (
        refusal := workers.upload_refusal(session, run.language, settings)
    ):
        return refusal
    mine = (Run.owner == run.owner) & (Run.state == RunState.RUNNING)
    running = session.scalar(select(func.count()).where(mine)) or 0
    if running >= settings.running_max:
        return f"{running} of your runs are running, which is the most at a time."
    if ahead == 0:
        return (
            "It is next: it starts as soon as a worker is free. After the first start of a service "
            "that takes some minutes, while the simulator is compiled."
        )
    return f"{ahead} run{'s are' if ahead > 1 else ' is'} before it, taken in turns between users."
