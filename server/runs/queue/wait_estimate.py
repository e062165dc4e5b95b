"""The position of a run in the queue, how long it will take, and why it waits.

Everything follows from one row per owner (record/turns.py) and from what was expected of each
run when it was submitted (paces.py). So it costs the same at any depth, and an estimate
changes only when the queue does.
"""

import time
from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from seamark.programs import parameters
from seamark.server.database.queue_tables import Turn
from seamark.server.database.tables import IS_QUEUED, IS_RUNNING, Run
from seamark.server.messaging import workers
from seamark.server.runs.queue import forecast, order, paces, queue
from seamark.server.runs.queue.forecast import Job, Slots
from seamark.server.runs.record import turns
from seamark.server.runs.record.solutions import IS_CONNECTED
from seamark.server.runs.record.states import RunState
from seamark.server.runs.record.turns import Priority
from seamark.server.settings import Settings
from seamark.sim import registry

SINGLE_RUNS_MAX = 100  # with more runs ahead, their mean duration is what matters


@dataclass(frozen=True, slots=True)
class Wait:
    """Position, time until the end and reason of the wait of a live run; None: unknown."""

    position: int | None
    estimate_s: float | None
    why: str | None


@dataclass(frozen=True, slots=True)
class _Work:
    """Queued runs, and the wall time [s] that they are expected to take one after the other."""

    runs: int
    wall_s: float

    def first(self, runs: int) -> "_Work":
        """Return some of these runs."""
        some = min(max(runs, 0), self.runs)
        return _Work(some, self.wall_s * some / self.runs if some else 0.0)

    def __add__(self, other: "_Work") -> "_Work":
        return _Work(self.runs + other.runs, self.wall_s + other.wall_s)


_NOTHING = _Work(0, 0.0)


def wait_of(session: Session, run: Run, settings: Settings) -> Wait:
    """Return the position of a queued run, and the time until the end of a live one."""
    expected_s, now = _expected_s(session, run), time.time()
    if run.state == RunState.RUNNING:
        return Wait(None, _left_s(run, now, settings, expected_s), None)
    mine = session.scalar(select(Turn).where(turns.IS_WAITING, Turn.owner == run.owner))
    if mine is None:  # claimed after it was read, which a writing transaction sees on PostgreSQL
        return Wait(None, expected_s, None)
    own = _own_ahead(session, run, mine)
    ahead = _ahead(session, mine, own)
    slots = workers.slot_count(session)
    estimate_s = None
    if slots and expected_s is not None:
        estimate_s = _until_start_s(session, mine, ahead, own, settings) + expected_s
    why = _why(session, run, settings, slots=slots, ahead=ahead.runs)
    return Wait(ahead.runs + 1, estimate_s, why)


def _own_ahead(session: Session, run: Run, mine: Turn) -> _Work:
    """Return the owner's own runs that start before this one."""
    before = (Run.owner == run.owner, IS_QUEUED, Run.id < run.id)
    count = session.scalar(select(func.count()).select_from(Run).where(*before)) or 0
    return _Work(mine.queued, mine.expected_s).first(count)


def _ahead(session: Session, mine: Turn, own: _Work) -> _Work:
    """Return the runs that start before the next one of `mine` after `own`, see `queue.claim`."""
    ahead = own + _of_equals(session, mine, own.runs)
    total = (func.sum(Turn.queued), func.sum(Turn.expected_s))
    others = select(Turn.priority, *total).where(turns.IS_WAITING).group_by(Turn.priority)
    waiting = {
        Priority(number): _Work(runs, wall_s) for number, runs, wall_s in session.execute(others)
    }
    accounts, guests = (waiting.get(p, _NOTHING) for p in (Priority.ACCOUNT, Priority.GUEST))
    passed_over = order.passed_over(session)
    if mine.priority == Priority.ACCOUNT:
        return ahead + guests.first(order.guests_among(ahead.runs, passed_over=passed_over))
    if mine.priority == Priority.GUEST:
        return ahead + accounts.first(order.accounts_before(ahead.runs, passed_over=passed_over))
    return ahead + accounts + guests


def _of_equals(session: Session, mine: Turn, before: int) -> _Work:
    """Return the runs of other owners of the same priority that start before `mine` + `before`."""
    count = order.runs_before(mine, before)
    others = select(func.sum(count), func.sum(count * Turn.expected_s / Turn.queued)).where(
        turns.IS_WAITING, Turn.priority == mine.priority, Turn.owner != mine.owner
    )
    runs, wall_s = session.execute(others).one()
    return _Work(runs or 0, float(wall_s or 0.0))


def _until_start_s(
    session: Session, mine: Turn, ahead: _Work, own: _Work, settings: Settings
) -> float:
    """Return the time [s] until a run starts, after the runs `ahead` of it, of which some `own`."""
    now = time.time()
    running = [
        (run.owner, _left_s(run, now, settings, run.expected_s) or 0.0)
        for run in session.scalars(select(Run).where(IS_RUNNING, ~IS_CONNECTED))
    ]
    limit = queue.running_limit(session, settings)
    slots = Slots(workers.slot_count(session), running, limit)
    if ahead.runs > SINGLE_RUNS_MAX:
        return forecast.start_of_many_s(slots, ahead.wall_s, mine.owner, own.wall_s)
    return forecast.start_s(slots, _jobs(session, mine, ahead, own), mine.owner)


def _jobs(session: Session, mine: Turn, ahead: _Work, own: _Work) -> list[Job]:
    """Return the runs ahead in the order in which they start, each as long as its owner's mean."""
    last = order.key(mine, own.runs)
    equals = select(Turn).where(
        turns.IS_WAITING, Turn.priority == mine.priority, Turn.running <= mine.running + own.runs
    )
    in_order = sorted(
        (order.key(turn, number), turn.owner, turn.mean_s)
        for turn in session.scalars(equals)
        for number in range(turn.queued)
    )
    jobs = [(owner, mean_s) for key, owner, mean_s in in_order if key < last]
    others = ahead.runs - len(jobs)
    if others <= 0:
        return jobs
    rest = [(forecast.OTHERS, (ahead.wall_s - sum(mean_s for _, mean_s in jobs)) / others)] * others
    accounts, guests = (jobs, rest) if mine.priority == Priority.ACCOUNT else (rest, jobs)
    passed_over = order.passed_over(session)
    return list(order.in_shares(accounts, guests, passed_over=passed_over))


def _expected_s(session: Session, run: Run) -> float | None:
    """Return the wall time [s] that a run is expected to take, whether or not it has started."""
    if run.expected_s is not None:
        return run.expected_s
    if run.benchmark not in registry.BENCHMARKS:  # most likely accepted by an older version
        return None
    # It was submitted before anything was measured.
    config = registry.benchmark(run.benchmark).restore(parameters.split(run.config)[0])
    return paces.expected_s(session, run, config.trial_duration_s())


def _left_s(run: Run, now: float, settings: Settings, expected_s: float | None) -> float | None:
    """Return the time [s] until the end of a running run.

    The further it is, the more its own pace counts, and the less what was expected. Both refer to
    the last heartbeat, when the progress was recorded: otherwise the estimate would grow until the
    next one.
    """
    if run.started_at is None or run.lease_until is None:
        return expected_s
    recorded_at = max(run.lease_until - settings.lease_s, run.started_at)
    elapsed, progress = recorded_at - run.started_at, run.progress
    if expected_s is not None:
        total = elapsed + (1.0 - progress) * expected_s
    elif progress > 0.05:  # earlier than that the pace of the run itself says little
        total = elapsed / progress
    else:
        return None
    return max(total * (1.0 - progress) - (now - recorded_at), 0.0)


def _why(session: Session, run: Run, settings: Settings, *, slots: int, ahead: int) -> str:
    if not slots:
        return "No worker is running. The run starts as soon as one is available."
    if obstacle := _obstacle(session, run, settings):
        return obstacle
    mine = (Run.owner == run.owner, IS_RUNNING, ~IS_CONNECTED)
    running = session.scalar(select(func.count()).select_from(Run).where(*mine)) or 0
    if running >= queue.running_limit(session, settings):
        one = "your run" if running == 1 else f"one of your {running} runs"
        return f"It waits until {one} has ended: no more of a user's may run at once."
    if ahead == 0:
        return "It starts when a worker is free."
    shared = "users take turns" if run.guest is None else "most runs of accounts go first"
    start = "run starts" if ahead == 1 else "runs start"
    return f"{ahead} {start} before it, because {shared}."


def _obstacle(session: Session, run: Run, settings: Settings) -> str | None:
    """Return why no worker could start the run now even if it were free; None if one could."""
    main = () if run.language is None else (run.language,)
    for language in (*main, *(part.language for part in run.parts)):
        if refusal := workers.upload_refusal(session, language, settings):
            return refusal
        if workers.waits_for_installation(session, language, settings):
            name = workers.finding_of(language)
            return f"The packages for {name} are being installed. The run starts after that."
    preparation = workers.preparation(session)
    return f"{preparation} The run starts after that." if preparation else None
