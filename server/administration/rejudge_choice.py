"""Which runs a rejudgement computes again, and what that costs: shown before it starts."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from sqlalchemy import ColumnElement, or_, select
from sqlalchemy.orm import Session

from seamark.server.database.tables import IS_LISTED, Result, Run
from seamark.server.runs.states import RunKind, RunState
from seamark.sim.recording.manifest import code_sha256

RUNS_MAX = 1000  # of one rejudgement: the newest that match; a later one can have the others
SEEN_MAX = 2000  # runs of the benchmark and the period that are looked at, the newest first
BUILT_IN = "built-in"


@dataclass(frozen=True, slots=True, kw_only=True)
class RunChoice:
    """Which runs are computed again; an empty field does not filter. Times are s since 1970."""

    benchmark: str
    kind: str = ""  # practice or ranked
    ended_from: float | None = None
    ended_to: float | None = None
    language: str = ""  # BUILT_IN: no uploaded program
    worker: str = ""  # that computed the run
    version: str = ""  # of Seamark, that computed the run
    other_code: bool = False  # computed by other simulator code than this service has now

    def as_dict(self) -> dict[str, Any]:
        """Return the fields that filter."""
        return {name: value for name, value in asdict(self).items() if value not in ("", None)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Chosen:
    """The runs that match, newest first, and what computing them again takes."""

    runs: Sequence[int]  # at most RUNS_MAX
    matching: int  # among the SEEN_MAX that were looked at
    complete: bool  # whether these are all runs of the benchmark and the period
    machine_s: float  # wall time that their first computation took, one after the other
    data_bytes: int  # that they may record


def choose(session: Session, choice: RunChoice) -> Chosen:
    """Return the runs that a rejudgement would compute again.

    Succeeded and failed ones whose program is still there; what its owner cancelled has no result.
    """
    period = _period(choice)
    window = (
        select(Run.id)
        .where(*period)
        .order_by(Run.finished_at.desc(), Run.id.desc())
        .limit(SEEN_MAX)
        .subquery()
    )
    columns = (Run.id, Run.started_at, Run.finished_at, Run.data_bytes)
    query = select(*columns).where(Run.id.in_(select(window.c.id)), *_conditions(choice))
    if choice.version or choice.other_code:
        query = query.outerjoin(Result, Result.run_id == Run.id)
    found = session.execute(query.order_by(Run.id.desc())).all()
    taken = found[:RUNS_MAX]
    next_one = select(Run.id).where(*period).limit(1).offset(SEEN_MAX)
    return Chosen(
        runs=[row.id for row in taken],
        matching=len(found),
        complete=session.scalar(next_one) is None,
        machine_s=sum((row.finished_at or 0.0) - (row.started_at or 0.0) for row in taken),
        data_bytes=sum(row.data_bytes for row in taken),
    )


def _period(choice: RunChoice) -> list[ColumnElement[bool]]:
    """Return the conditions that an index has."""
    found: list[ColumnElement[bool]] = [
        Run.benchmark == choice.benchmark,
        Run.finished_at.is_not(None),
    ]
    if choice.ended_from is not None:
        found.append(Run.finished_at >= choice.ended_from)
    if choice.ended_to is not None:
        found.append(Run.finished_at < choice.ended_to)
    return found


def _conditions(choice: RunChoice) -> list[ColumnElement[bool]]:
    with_program = or_(Run.program_sha256.is_(None), Run.data_deleted_at.is_(None))
    ended = Run.state.in_((RunState.SUCCEEDED, RunState.FAILED))
    found = [IS_LISTED, ended, Run.started_at.is_not(None), Run.deleted_at.is_(None), with_program]
    if choice.kind:
        found.append(Run.kind == RunKind(choice.kind))
    if choice.language == BUILT_IN:
        found.append(Run.language.is_(None))
    elif choice.language:
        found.append(Run.language == choice.language)
    if choice.worker:
        its_slots = Run.worker.startswith(f"{choice.worker}/", autoescape=True)
        found.append(or_(Run.worker == choice.worker, its_slots))
    if choice.version:
        found.append(Result.manifest["versions"]["seamark"].as_string() == choice.version)
    if choice.other_code:
        code = Result.manifest["code_sha256"].as_string()
        found.append(or_(code.is_(None), code != code_sha256()))
    return found


def from_dict(stored: Mapping[str, Any]) -> RunChoice:
    """Return the choice that `RunChoice.as_dict` has written."""
    return RunChoice(**stored)
