"""The state machine of a run: one table of transitions and one function that makes them."""

import time
from enum import StrEnum
from functools import lru_cache
from typing import Any

from sqlalchemy import ColumnElement, Row, and_, bindparam, or_, update
from sqlalchemy.orm import InstrumentedAttribute, Session
from sqlalchemy.orm.util import identity_key
from sqlalchemy.sql.dml import ReturningUpdate

from seamark.programs.failure_reasons import FailureReason
from seamark.server.database.engine import after_commit
from seamark.server.database.tables import Run
from seamark.server.monitoring import meters
from seamark.server.runs.record import run_notices, turns


class RunState(StrEnum):
    """The state of a run. Succeeded, failed and cancelled are final: a rerun is a new run."""

    QUEUED = "queued"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"

    @property
    def final(self) -> bool:
        """Whether a run in this state can no longer change."""
        return self not in NEXT_STATES


class RunKind(StrEnum):
    """What a run is for: practice on a seed of one's own, or a rank on those of the benchmark.

    An entry counts in a round of a competition. A log is no simulation: the log of a real mission,
    measured like a run.
    """

    PRACTICE = "practice"
    RANKED = "ranked"
    ENTRY = "entry"
    LOG = "log"


NEXT_STATES: dict[RunState, frozenset[RunState]] = {
    RunState.QUEUED: frozenset({RunState.RUNNING, RunState.CANCELLED}),
    RunState.RUNNING: frozenset(
        {RunState.SUCCEEDED, RunState.FAILED, RunState.CANCELLED, RunState.QUEUED}
    ),
}
LIVE = tuple(NEXT_STATES)
FINAL = tuple(state for state in RunState if state.final)
_TOLD = (RunState.SUCCEEDED, RunState.FAILED)  # by e-mail; who cancels a run knows


_NEW = "new_"  # before the names of bound values: those of columns are reserved
Returning = tuple[InstrumentedAttribute[Any], ...]


class IllegalMove(Exception):
    """A bug: the table of transitions does not have this one."""


def move(
    session: Session,
    run_id: int,
    old: RunState,
    new: RunState,
    *,
    fence: int | None = None,
    returning: Returning = (),
    **values: Any,
) -> Row[Any] | None:
    """Move a run to its next state; None if another process was faster.

    Parameters
    ----------
    fence
        Only the holder of this attempt can move it. A run that starts has its next attempt.
    returning
        Columns of the run, as they are then, that are returned beside its owner and kind.
    **values
        Columns written in the same statement: values or expressions.
    """
    if new not in NEXT_STATES.get(old, frozenset()):
        raise IllegalMove(f"run {run_id}: {old} -> {new}")
    if new.final:
        values |= {"finished_at": time.time(), "lease_until": None, "trial_seeds": None}
    session.flush()
    computed = {name: value for name, value in values.items() if isinstance(value, ColumnElement)}
    plain = tuple(sorted(values.keys() - computed.keys()))
    change = _change(old, new, fence is not None, plain, returning)
    if computed:
        change = change.values(**computed)
    bound = {_NEW + name: values[name] for name in plain}
    moved = session.connection().execute(change, bound | {"run": run_id, "fence": fence}).first()
    if moved is None:
        return None
    if (loaded := session.identity_map.get(identity_key(Run, run_id))) is not None:
        session.expire(loaded, ["state", "attempt", *values])
    turns.refresh(session, moved.owner, served=new is RunState.RUNNING)
    if new in _TOLD:
        run_notices.note(session, run_id)
    if new.final:
        ended = meters.RUNS_ENDED.labels(moved.kind, new, values.get("cause") or "")
        after_commit(session, ended.inc)
    return moved


@lru_cache(maxsize=64)
def _change(
    old: RunState, new: RunState, fenced: bool, names: tuple[str, ...], returning: Returning
) -> ReturningUpdate[*tuple[Any, ...]]:
    """Build the statement once: that takes longer than the database needs for it."""
    columns = {name: bindparam(_NEW + name, type_=getattr(Run, name).type) for name in names}
    # One conditional UPDATE: of two processes only one can make the transition.
    change = update(Run).where(Run.id == bindparam("run"), Run.state == old)
    change = change.values(state=new, **columns)
    if fenced:
        change = change.where(Run.attempt == bindparam("fence"))
    if new is RunState.RUNNING:
        change = change.values(attempt=Run.attempt + 1)
    return change.returning(Run.owner, Run.kind, *returning)


def ranked_ended() -> ColumnElement[bool]:
    """Return the condition on `Run`: a ranked run of which its user has seen something."""
    return and_(Run.kind == RunKind.RANKED, seen_ended())


def seen_ended() -> ColumnElement[bool]:
    """Return the condition on `Run`: whoever submitted it has seen something of it.

    It ended, not by a failure of the platform, or was cancelled after it had started.
    """
    failed = and_(Run.state == RunState.FAILED, Run.cause != FailureReason.PLATFORM_ERROR)
    cancelled = and_(Run.state == RunState.CANCELLED, Run.started_at.is_not(None))
    return or_(Run.state == RunState.SUCCEEDED, failed, cancelled)
