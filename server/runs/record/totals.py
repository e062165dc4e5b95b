"""How many runs there are in each state, and how much they simulated: at the cost of a few rows.

Runs that ended long ago are counted once, by the maintenance of the workers, and added to counters;
later ones are counted when somebody asks. A counter in each transaction that ends a run would be a
row that all of them wait for.
"""

import time
from typing import Any

from sqlalchemy import ColumnElement, case, func, literal, select
from sqlalchemy.orm import InstrumentedAttribute, Session

from seamark.server.database import counters
from seamark.server.database.queue_tables import Turn
from seamark.server.database.tables import IS_LISTED, IS_QUEUED, IS_RUNNING, Run
from seamark.server.runs.record.states import FINAL, RunState
from seamark.server.runs.record.turns import Priority

SIMULATED, UNTIL = "simulated_s", "counted_until"
ENDED = "ended:"  # and a state
EVERY_S = 60.0  # at least between two countings
LATE_S = 60.0  # a transaction that is open meanwhile may store an earlier time of its end


def counts(session: Session) -> dict[RunState, int]:
    """Return how many runs there are in each state; ended ones that were deleted count too."""
    return counts_and_simulated_s(session)[0]


def counts_and_simulated_s(session: Session) -> tuple[dict[RunState, int], float]:
    """Return `counts`, and the simulated time [s] of all runs, also of those that are running."""
    counted = counters.values(session, (UNTIL, SIMULATED, *(ENDED + state for state in FINAL)))
    recent, recent_s = _ended_after(session, counted[UNTIL])
    queued, running, running_s = session.execute(_LIVE).one()
    ended = {state: int(counted[ENDED + state]) + recent[state] for state in FINAL}
    live = {RunState.QUEUED: queued, RunState.RUNNING: running}
    return live | ended, counted[SIMULATED] + running_s + recent_s


def _of_rejudgements(column: InstrumentedAttribute[int]) -> ColumnElement[int]:
    """Return how many queued or running runs belong to rejudgements."""
    none = literal(0, literal_execute=True)  # as the partial indexes have it
    its = (column > none, Turn.priority == int(Priority.REJUDGEMENT))
    return _sum(column, *its)


def _sum(column: InstrumentedAttribute[Any], *rows: ColumnElement[bool]) -> ColumnElement[Any]:
    return func.coalesce(select(func.sum(column)).where(*rows).scalar_subquery(), 0)


def _number(rows: ColumnElement[bool]) -> ColumnElement[int]:
    return select(func.count()).where(rows).scalar_subquery()


# Not with IS_LISTED where runs are counted: the index for it does not have it, but turns do.
_LIVE = select(
    _number(IS_QUEUED) - _of_rejudgements(Turn.queued),
    _number(IS_RUNNING) - _of_rejudgements(Turn.running),
    _sum(Run.t_simulated, IS_RUNNING, IS_LISTED),
)


def oldest_queued_at(session: Session) -> float | None:
    """Return since when the oldest queued run waits; None if the queue is empty."""
    return session.scalar(select(func.min(Run.queued_at)).where(IS_QUEUED, IS_LISTED))


def count_ended(session: Session) -> None:
    """Add the runs that have ended since the last time to the counters. One process at a time."""
    since, until = counters.value(session, UNTIL), time.time() - LATE_S
    if until - since < EVERY_S:  # just counted, or the clock was changed
        return
    ended, simulated = _ended_after(session, since, until)
    for state, number in ended.items():
        counters.add(session, ENDED + state, number)
    counters.add(session, SIMULATED, simulated)
    counters.store(session, UNTIL, until)


def _ended_after(
    session: Session, since: float, until: float | None = None
) -> tuple[dict[RunState, int], float]:
    """Return how many runs ended in a period, by state, and their simulated time [s]."""
    # Not GROUP BY: SQLite would read all runs in the order of their states.
    each = [func.sum(case((Run.state == state, 1), else_=0)) for state in FINAL]
    query = select(func.sum(Run.t_simulated), *each).where(Run.finished_at > since, IS_LISTED)
    if until is not None:
        query = query.where(Run.finished_at <= until)
    simulated, *numbers = session.execute(query).one()
    return {
        state: number or 0 for state, number in zip(FINAL, numbers, strict=True)
    }, simulated or 0.0


def change_state(session: Session, run: Run, new: RunState) -> None:
    """Count a run that ended under another state, in the transaction that changes it."""
    if run.finished_at is not None and run.finished_at <= counters.value(session, UNTIL):
        counters.add(session, ENDED + run.state, -1)
        counters.add(session, ENDED + new, 1)
