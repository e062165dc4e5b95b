"""The state machine of a run: one table of transitions and one function that makes them."""

import time
from enum import StrEnum
from typing import Any

from sqlalchemy import update
from sqlalchemy.orm import Session

from seamark.server import meters
from seamark.server.database.engine import after_commit
from seamark.server.database.tables import Run
from seamark.server.runs import turns


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
    """What a run is for: practice on a seed of one's own, or a rank on those of the benchmark."""

    PRACTICE = "practice"
    RANKED = "ranked"


NEXT_STATES: dict[RunState, frozenset[RunState]] = {
    RunState.QUEUED: frozenset({RunState.RUNNING, RunState.CANCELLED}),
    RunState.RUNNING: frozenset(
        {RunState.SUCCEEDED, RunState.FAILED, RunState.CANCELLED, RunState.QUEUED}
    ),
}
LIVE = tuple(NEXT_STATES)
FINAL = tuple(state for state in RunState if state.final)


class IllegalMove(Exception):
    """A bug: the table of transitions does not have this one."""


def move(
    session: Session,
    run_id: int,
    old: RunState,
    new: RunState,
    *,
    fence: int | None = None,
    **values: Any,
) -> bool:
    """Move a run to its next state; False if another process was faster.

    With `fence` only the holder of that attempt can move it. `values` are columns written in the
    same statement.
    """
    if new not in NEXT_STATES.get(old, frozenset()):
        raise IllegalMove(f"run {run_id}: {old} -> {new}")
    if new.final:
        values |= {"finished_at": time.time(), "lease_until": None}
    # One conditional UPDATE: of two processes only one can make the transition.
    change = update(Run).where(Run.id == run_id, Run.state == old).values(state=new, **values)
    if fence is not None:
        change = change.where(Run.attempt == fence)
    moved = session.execute(change.returning(Run.owner, Run.kind)).one_or_none()
    if moved is None:
        return False
    turns.refresh(session, moved.owner, served=new is RunState.RUNNING)
    if new.final:
        ended = meters.RUNS_ENDED.labels(moved.kind, new, values.get("cause") or "")
        after_commit(session, ended.inc)
    return True
