"""Runs as pages and the API show them: values, not rows, and no seed but a chosen one."""

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import Select, select
from sqlalchemy.orm import Session, defer, undefer

from seamark.sandbox.printable_text import printable_text
from seamark.server.classes import classrooms
from seamark.server.database.competition_tables import Entry, Team
from seamark.server.database.tables import IS_LISTED, Result, Run, User
from seamark.server.runs.data.error_curve import Curve
from seamark.server.runs.queue import wait_estimate
from seamark.server.runs.record import anonymity, entries, run_files, run_parts
from seamark.server.runs.record.columns import OwnFile, Part, PublicRun
from seamark.server.runs.record.entries import EntryAccess
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.settings import Settings

_Selection = Select[Run, Result | None, User | None, str | None]
_OF_PROGRAM = frozenset(("traceback", "log_tail"))


class RunView(PublicRun):
    """A run as pages and the API read it. Lists have neither metrics nor manifest."""

    user_id: int | None
    guest: str | None
    program_sha256: str | None
    files: tuple[OwnFile, ...] = ()  # of the user's own, but for the vehicle's
    sweep_cell: int | None = None
    detail: dict[str, Any]  # title, sentence, remedy, traceback, log_tail, t_reached; when failed
    score: float | None = None
    score_low: float | None = None
    score_high: float | None = None
    level_held: float | None = None
    rankable: bool | None = None  # False: the rules of the benchmark keep it off the leaderboard
    error_curve: Curve | None = None
    digest: str | None = None
    manifest: dict[str, Any] | None = None
    data_run: int | None = None
    draw: int | None = None  # none that is shown has one
    hidden_names: tuple[str, ...] = ()  # of an anonymous run's programs, which its log may quote
    teacher_id: int | None = None  # of the class it was submitted for; not in lists
    entry: EntryAccess | None = None  # of a competition; not in lists

    @property
    def has_programs(self) -> bool:
        """Whether programs were uploaded for it: one of its benchmark's role, or parts."""
        return self.program_sha256 is not None or bool(self.parts)

    @property
    def data_id(self) -> int:
        """The number of the run that recorded its data: another one if it was computed again."""
        return self.data_run or self.id

    @property
    def version(self) -> str:
        """A text that changes whenever the view does: for an ETag."""
        progress = (self.state, self.attempt, round(self.progress, 3), self.position)
        result = (self.data_run, self.score, self.cause)  # it may be computed again
        shown = (self.public, self.anonymous, self.licence, self.title, self.notes)
        parts = (*progress, *result, *shown, self.data_deleted_at)
        return "-".join(str(part) for part in parts)


def show(session: Session, run_id: int, settings: Settings | None = None) -> RunView | None:
    """Return one run, or None. With settings also its position in the queue."""
    whole = selection().options(undefer(Run.program_parameters))
    query = whole.where(Run.id == run_id, Run.deleted_at.is_(None), IS_LISTED)
    rows = session.execute(query).one_or_none()
    if rows is None:
        return None
    run, result, user, team = rows
    run_parts.load(session, [run])
    run_files.load(session, [run])
    more: dict[str, object] = {
        "teacher_id": classrooms.teacher_of(session, run_id),
        "entry": entries.access_of(session, run),
    }
    if settings is None or RunState(run.state).final:
        return view(run, result, user, team, **more)
    wait = wait_estimate.wait_of(session, run, settings)
    waiting = {"position": wait.position, "estimate_s": wait.estimate_s, "why_waiting": wait.why}
    return view(run, result, user, team, **more, **waiting)


def several(session: Session, run_ids: Sequence[int], *, metrics: bool = False) -> list[RunView]:
    """Return those runs of these that are there, in this order, as lists show them.

    Only with `metrics` they have these.
    """
    # A list shows neither: parsing the metrics of large grids would take most of its time.
    query = selection().options(defer(Result.manifest))
    query = query if metrics else query.options(defer(Result.metrics))
    query = query.where(Run.id.in_(run_ids), Run.deleted_at.is_(None), IS_LISTED)
    views = _views(session, query) if run_ids else []
    rows = {each.id: each for each in views}
    return [rows[run_id] for run_id in run_ids if run_id in rows]


def of_sweep(session: Session, sweep_id: int) -> list[RunView]:
    """Return the runs of a sweep, cell by cell, without metrics."""
    query = selection().where(Run.sweep_id == sweep_id, Run.deleted_at.is_(None))
    query = query.options(defer(Result.metrics), defer(Result.manifest)).order_by(Run.sweep_cell)
    return _views(session, query)


def _views(
    session: Session, query: Select[Run, Result | None, User | None, str | None]
) -> list[RunView]:
    rows = session.execute(query).all()
    run_parts.load(session, (row[0] for row in rows))
    run_files.load(session, (row[0] for row in rows))
    return [view(*row) for row in rows]


def selection() -> _Selection:
    """Select what `view` needs of runs."""
    return (
        select(Run, Result, User, Team.name)
        .outerjoin(Result, Result.run_id == Run.id)
        .outerjoin(User, User.id == Run.user_id)
        .outerjoin(Entry, Entry.run_id == Run.id)
        .outerjoin(Team, Team.id == Entry.team_id)
    )


def view(
    run: Run, result: Result | None, user: User | None, team: str | None, /, **more: object
) -> RunView:
    """Return the values of a run from its rows; that of a competition is its team's."""
    name, is_baseline = ("guest", False) if user is None else (user.name, user.is_baseline)
    if run.kind == RunKind.ENTRY:
        name, is_baseline = team or entries.REFERENCE, team is None
    shown = RunView.from_rows(result, run, user=name, is_baseline=is_baseline, **more)
    # Printable when it was stored by this version; not by an earlier one.
    detail = {name: _shown(value) for name, value in shown.detail.items()}
    if run.public and not run.program_public:  # they quote the program and what it prints
        detail = {name: value for name, value in detail.items() if name not in _OF_PROGRAM}
    return shown.model_copy(update={"detail": detail} | _masked(run, detail))


def _masked(run: Run, detail: Mapping[str, object]) -> dict[str, object]:
    """Return what stands in place of values that tell who published a run for review."""
    if not run.anonymous:
        return {}
    parts = [Part.model_validate(part) for part in run.parts]
    names = [name for name in (run.program_name, *(part.program_name for part in parts)) if name]
    for name in names:
        by = anonymity.file_name(name) or ""
        detail = {key: anonymity.replaced(value, name, by) for key, value in detail.items()}
    return {
        "rerun_of": None,
        "sweep_id": None,
        "user": anonymity.NAME,
        "program_name": anonymity.file_name(run.program_name),
        "parts": tuple(map(_without_name, parts)),
        "hidden_names": tuple(names),
        "detail": detail,
    }


def _without_name(part: Part) -> Part:
    return part.model_copy(update={"program_name": anonymity.file_name(part.program_name)})


def _shown(value: object) -> object:
    return printable_text(value) if isinstance(value, str) else value
