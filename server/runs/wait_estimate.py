"""The position of a run in the queue, how long it will take, and why it waits."""

import time
from collections.abc import Collection
from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from seamark.server import workers
from seamark.server.accounts.permissions import GUESTS
from seamark.server.database.tables import Run, Turn, User
from seamark.server.runs.states import RunState
from seamark.server.settings import Settings

_RECENT = 20  # finished runs of the benchmark from which a duration is estimated


@dataclass(frozen=True, slots=True)
class Wait:
    """Position, time until the end and reason of the wait of a live run; None: unknown."""

    position: int | None
    estimate_s: float | None
    why: str | None


def wait_of(session: Session, run: Run, settings: Settings) -> Wait:
    """Return the position of a queued run, and the time until the end of a live one."""
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
    """Return the position, 1 = next, in rounds: the first run of every owner, then the second ...

    Computed from one row per owner, so that a long queue costs no more than a short one. None if a
    worker claimed the run after it was read, which a writing transaction sees on PostgreSQL.
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
    """What one owner has in the queue."""

    queued: int
    first: int  # id of the run that is next
    running: int
    served_at: float
    after: int  # those of a lower number start first, see `queue.claim`

    def ahead_of(self, mine: "_Owner", before: int) -> int:
        """Return how many of its runs start before run number `before` + 1 of `mine`."""
        if self.after != mine.after:
            return self.queued if self.after < mine.after else 0
        rounds = mine.running + before - self.running
        turn = (self.served_at, self.first) < (mine.served_at, mine.first)
        return min(max(rounds + int(turn), 0), self.queued)


def _owners(session: Session) -> dict[str, _Owner]:
    """Return the owners that have queued runs."""
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
        owner: _Owner(n, first, running.get(owner, 0), served_at, _after(owner, baselines))
        for owner, n, first, served_at in session.execute(queued)
    }


def _after(owner: str, baselines: Collection[str]) -> int:
    """Return 0 for accounts, 1 for guests, 2 for baselines."""
    return 2 if owner in baselines else int(owner.startswith(GUESTS))


def _typical_s(session: Session, run: Run) -> float | None:
    """Return the mean duration of recent runs of the benchmark, scaled to the number of trials."""
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
    if run.progress > 0.05:  # earlier than that the pace of the run itself says little
        return elapsed * (1.0 - run.progress) / run.progress
    return None if typical is None else max(typical - elapsed, 0.0)


def _why(session: Session, run: Run, settings: Settings, *, slots: int, ahead: int) -> str:
    if not slots:
        return "No worker is running. The run starts as soon as one is available."
    if run.language is not None and (
        refusal := workers.upload_refusal(session, run.language, settings)
    ):
        return refusal
    mine = (Run.owner == run.owner) & (Run.state == RunState.RUNNING)
    running = session.scalar(select(func.count()).where(mine)) or 0
    if running >= settings.running_max:
        return f"{running} of your runs are running, which is the limit."
    if ahead == 0:
        return (
            "It is next and starts as soon as a worker is free. After the very first start of a "
            "service this takes some minutes, while the simulator is being compiled."
        )
    turns = "users take turns" if run.guest is None else "those of accounts start first"
    return f"{ahead} run{'s' if ahead > 1 else ''} ahead of it; {turns}."
