"""Runs as pages and the API show them: values, not rows, and no seed but a chosen one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from sqlalchemy import ColumnElement, Select, func, select
from sqlalchemy.orm import Session, aliased, defer, undefer

from seamark.sandbox.printable_text import printable_text
from seamark.server.accounts.permissions import Action, Viewer, can
from seamark.server.classes import classrooms
from seamark.server.database.tables import Result, Run, User
from seamark.server.runs import wait_estimate
from seamark.server.runs.columns import PublicRun
from seamark.server.runs.states import RunState
from seamark.server.settings import Settings

LIMIT_MAX = 200
SEEN_MAX = 1000  # runs that a page of a list looks at


class RunView(PublicRun):
    """A run as pages and the API read it. Lists have neither metrics nor manifest."""

    user_id: int | None
    guest: str | None
    program_sha256: str | None
    sweep_cell: int | None = None
    detail: dict[str, Any]  # title, sentence, remedy, traceback, log_tail, t_reached; when failed
    score: float | None = None
    score_low: float | None = None
    score_high: float | None = None
    level_held: float | None = None
    rankable: bool | None = None  # False: the rules of the benchmark keep it off the leaderboard
    digest: str | None = None
    manifest: dict[str, Any] | None = None
    teacher_id: int | None = None  # of the class it was submitted for; not in lists

    @property
    def version(self) -> str:
        """A text that changes whenever the view does: for an ETag."""
        progress = (self.state, self.attempt, round(self.progress, 3), self.position)
        parts = (*progress, self.public, self.data_deleted_at)
        return "-".join(str(part) for part in parts)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunFilter:
    """Which runs a list shows; a field that is left out does not filter."""

    which: Literal["mine", "public", "all"] = "mine"
    user: str | None = None
    states: Sequence[RunState] = ()
    benchmark: str | None = None
    kind: str | None = None


@dataclass(frozen=True, slots=True)
class RunPage:
    """A page of a list; `next` is the `after` of the following page, None at the end."""

    runs: list[RunView]
    next: int | None


def show(session: Session, run_id: int, settings: Settings | None = None) -> RunView | None:
    """Return one run, or None. With settings also its position in the queue."""
    whole = _select().options(undefer(Run.program_parameters))
    rows = session.execute(whole.where(Run.id == run_id)).one_or_none()
    if rows is None:
        return None
    run, result, user = rows
    teacher_id = classrooms.teacher_of(session, run_id)
    if settings is None or RunState(run.state).final:
        return _view(run, result, user, teacher_id=teacher_id)
    wait = wait_estimate.wait_of(session, run, settings)
    waiting = {"position": wait.position, "estimate_s": wait.estimate_s, "why_waiting": wait.why}
    return _view(run, result, user, teacher_id=teacher_id, **waiting)


def of_sweep(session: Session, sweep_id: int) -> list[RunView]:
    """Return the runs of a sweep, cell by cell, without metrics."""
    query = _select().where(Run.sweep_id == sweep_id).order_by(Run.sweep_cell)
    query = query.options(defer(Result.metrics), defer(Result.manifest))
    return [_view(*row) for row in session.execute(query)]


def page(
    session: Session,
    viewer: Viewer,
    run_filter: RunFilter,
    *,
    after: int | None = None,
    limit: int = 50,
) -> RunPage:
    """Return runs, newest first: the viewer's own, the public ones, or (for an admin) all.

    A page looks at no more than `SEEN_MAX` of them: with a filter that few pass it may be short or
    empty and yet have a next one.
    """
    limit = max(1, min(limit, LIMIT_MAX))
    whose = _whose(session, viewer, run_filter)
    if after is not None:
        whose = whose.where(Run.id < after)
    filtered = bool(run_filter.states or run_filter.benchmark or run_filter.kind)
    most = SEEN_MAX if filtered else limit + 1
    seen = aliased(Run, whose.order_by(Run.id.desc()).limit(most).subquery())
    query = _select(seen).where(*_conditions(seen, run_filter))
    query = query.order_by(seen.id.desc()).limit(limit + 1)
    # A list shows neither: parsing the metrics of large grids would take most of its time.
    query = query.options(defer(Result.metrics), defer(Result.manifest))
    found = [_view(*row) for row in session.execute(query)]
    if len(found) > limit:
        return RunPage(found[:limit], found[limit - 1].id)
    last = select(func.min(seen.id)).having(func.count() == SEEN_MAX)
    return RunPage(found, session.scalar(last) if filtered else None)


def _conditions(run: type[Run], run_filter: RunFilter) -> list[ColumnElement[bool]]:
    conditions: list[ColumnElement[bool]] = []
    if run_filter.states:
        conditions.append(run.state.in_(run_filter.states))
    if run_filter.benchmark is not None:
        conditions.append(run.benchmark == run_filter.benchmark)
    if run_filter.kind is not None:
        conditions.append(run.kind == run_filter.kind)
    return conditions


def _whose(session: Session, viewer: Viewer, run_filter: RunFilter) -> Select[Run]:
    """Select the runs that a list is about, by an index in the order of their ids."""
    query = select(Run)
    if run_filter.which == "public":
        query = query.where(Run.public)
    elif run_filter.which == "mine" or not can(viewer, Action.ADMINISTER):
        # Guests of one network have one owner, but each sees the runs of the own cookie alone.
        own = Run.owner == (viewer.owner or "")
        query = query.where(own if viewer.guest is None else Run.guest == viewer.guest)
    elif run_filter.user is None and len(run_filter.states) == 1:
        query = query.where(Run.state == run_filter.states[0])
    if run_filter.user is not None:
        named = select(User.id).where(User.name_key == run_filter.user.casefold())
        query = query.where(Run.owner == Viewer(user_id=session.scalar(named) or 0).owner)
    return query


def _select(run: type[Run] = Run) -> Select[Run, Result | None, User | None]:
    return (
        select(run, Result, User)
        .outerjoin(Result, Result.run_id == run.id)
        .outerjoin(User, User.id == run.user_id)
    )


def _view(run: Run, result: Result | None, user: User | None, /, **more: object) -> RunView:
    name, is_baseline = ("guest", False) if user is None else (user.name, user.is_baseline)
    view = RunView.from_rows(result, run, user=name, is_baseline=is_baseline, **more)
    # Printable when it was stored by this version; not by an earlier one.
    detail = {name: _shown(value) for name, value in view.detail.items()}
    return view.model_copy(update={"detail": detail})


def _shown(value: object) -> object:
    return printable_text(value) if isinstance(value, str) else value
