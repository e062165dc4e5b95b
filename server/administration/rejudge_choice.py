"""Which runs a rejudgement computes again, and what that costs: shown before it starts."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from sqlalchemy import ColumnElement, and_, or_, select
from sqlalchemy.orm import Session
from sqlalchemy.sql.base import ReadOnlyColumnCollection
from sqlalchemy.sql.elements import KeyedColumnElement

from seamark.server.database.tables import Result, Run, RunPart
from seamark.server.runs.record.solutions import ROSBRIDGE
from seamark.server.runs.record.states import RunKind, RunState
from seamark.sim.recording.manifest import code_sha256

RUNS_MAX = 1000  # of the benchmark and the period that are looked at, the newest first
BUILT_IN = "built-in"
_COLUMNS = (
    *(Run.id, Run.kind, Run.state, Run.started_at, Run.finished_at, Run.deleted_at, Run.rejudges),
    *(
        Run.data_bytes,
        Run.data_deleted_at,
        Run.program_sha256,
        Run.language,
        Run.worker,
        Run.controller,
    ),
)
_Columns = ReadOnlyColumnCollection[str, KeyedColumnElement[Any]]


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

    runs: Sequence[int]
    complete: bool  # whether all runs of the benchmark and the period were looked at
    machine_s: float  # wall time that their first computation took, one after the other
    data_bytes: int  # that they may record


def choose(session: Session, choice: RunChoice) -> Chosen:
    """Return the runs that a rejudgement would compute again.

    Succeeded and failed ones whose program is still there; what its owner cancelled has no result.
    """
    period = _period(choice)
    newest = select(*_COLUMNS).where(*period).order_by(Run.finished_at.desc(), Run.id.desc())
    window = newest.limit(RUNS_MAX).subquery("seen")
    seen = window.c
    columns = (seen.id, seen.started_at, seen.finished_at, seen.data_bytes)
    query = select(*columns).where(*_conditions(choice, seen))
    rows = session.execute(query.order_by(seen.id.desc())).all()
    next_one = select(Run.id).where(*period).limit(1).offset(RUNS_MAX)
    return Chosen(
        runs=[row.id for row in rows],
        complete=session.scalar(next_one) is None,
        machine_s=sum((row.finished_at or 0.0) - (row.started_at or 0.0) for row in rows),
        data_bytes=sum(row.data_bytes for row in rows),
    )


def _period(choice: RunChoice) -> list[ColumnElement[bool]]:
    """Return the conditions that an index has."""
    conditions: list[ColumnElement[bool]] = [
        Run.benchmark == choice.benchmark,
        Run.finished_at.is_not(None),
    ]
    if choice.ended_from is not None:
        conditions.append(Run.finished_at >= choice.ended_from)
    if choice.ended_to is not None:
        conditions.append(Run.finished_at < choice.ended_to)
    return conditions


def _conditions(choice: RunChoice, seen: _Columns) -> list[ColumnElement[bool]]:
    parts = select(RunPart.run_id).where(RunPart.run_id == seen.id).exists()
    # The cheap condition first: it holds for most runs.
    with_program = or_(seen.data_deleted_at.is_(None), and_(seen.program_sha256.is_(None), ~parts))
    conditions = [
        # Nothing computes these.
        *(seen.kind != RunKind.LOG, seen.controller != ROSBRIDGE),
        *(seen.rejudges.is_(None), seen.deleted_at.is_(None), seen.started_at.is_not(None)),
        *(seen.state.in_((RunState.SUCCEEDED, RunState.FAILED)), with_program),
    ]
    if choice.kind:
        conditions.append(seen.kind == RunKind(choice.kind))
    if choice.language == BUILT_IN:
        conditions.append(seen.language.is_(None))
    elif choice.language:
        conditions.append(seen.language == choice.language)
    if choice.worker:
        its_slots = seen.worker.startswith(f"{choice.worker}/", autoescape=True)
        conditions.append(or_(seen.worker == choice.worker, its_slots))
    manifest = select(Result.manifest).where(Result.run_id == seen.id).scalar_subquery()
    if choice.version:
        conditions.append(manifest["versions"]["seamark"].as_string() == choice.version)
    if choice.other_code:
        code = manifest["code_sha256"].as_string()
        conditions.append(or_(code.is_(None), code != code_sha256()))
    return conditions


def from_dict(stored: Mapping[str, Any]) -> RunChoice:
    """Return the choice that `RunChoice.as_dict` has written."""
    return RunChoice(**stored)
