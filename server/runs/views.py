"""Runs as pages and the API show them: values, not rows, and no seed but a chosen one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from sqlalchemy import Select, func, select
from sqlalchemy.orm import Session, defer

from seamark.sandbox.printable_text import printable_text
from seamark.server.accounts.permissions import Action, Viewer, can
from seamark.server.database.tables import Result, Run, User
from seamark.server.runs import wait_estimate
from seamark.server.runs.columns import PublicRun
from seamark.server.runs.states import RunState
from seamark.server.settings import Settings

LIMIT_MAX = 200


class RunView(PublicRun):
    """A run as pages and the API read it. Lists have neither metrics nor manifest."""

    user_id: int | None
    guest: str | None
    program_sha256: str | None
    detail: dict[str, Any]  # title, sentence, remedy, traceback, log_tail, t_reached; when failed
    score: float | None = None
    score_low: float | None = None
    score_high: float | None = None
    level_held: float | None = None
    rankable: bool | None = None  # False: the rules of the benchmark keep it off the leaderboard
    digest: str | None = None
    manifest: dict[str, Any] | None = None

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
    rows = session.execute(_select().where(Run.id == run_id)).one_or_none()
    if rows is None:
        return None
    run, result, user = rows
    if settings is None or RunState(run.state).final:
        return _view(run, result, user)
    wait = wait_estimate.wait_of(session, run, settings)
    waiting = {"position": wait.position, "estimate_s": wait.estimate_s, "why_waiting": wait.why}
    return _view(run, result, user, **waiting)


def page(
    session: Session,
    viewer: Viewer,
    run_filter: RunFilter,
    *,
    after: int | None = None,
    limit: int = 50,
) -> RunPage:
    """Return runs, newest first: the viewer's own, the public ones, or (for an admin) all."""
    query = _select()
    if run_filter.which == "public":
        query = query.where(Run.public)
    elif run_filter.which == "mine" or not can(viewer, Action.ADMINISTER):
        # Guests of one network have one owner, but each sees the runs of the own cookie alone.
        own = Run.owner == (viewer.owner or "")
        query = query.where(own if viewer.guest is None else Run.guest == viewer.guest)
    if run_filter.user is not None:
        query = query.where(User.name_key == run_filter.user.casefold())
    if run_filter.states:
        query = query.where(Run.state.in_(run_filter.states))
    if run_filter.benchmark is not None:
        query = query.where(Run.benchmark == run_filter.benchmark)
    if run_filter.kind is not None:
        query = query.where(Run.kind == run_filter.kind)
    if after is not None:
        query = query.where(Run.id < after)
    limit = max(1, min(limit, LIMIT_MAX))
    # A list shows neither: parsing the metrics of large grids would take most of its time.
    query = query.options(defer(Result.metrics), defer(Result.manifest))
    found = session.execute(query.order_by(Run.id.desc()).limit(limit + 1)).all()
    views = [_view(*row) for row in found[:limit]]
    return RunPage(views, views[-1].id if len(found) > limit else None)


def counts(session: Session) -> dict[RunState, int]:
    """Return how many runs there are in each state."""
    by_state = dict(session.execute(select(Run.state, func.count()).group_by(Run.state)).all())
    return {state: by_state.get(state, 0) for state in RunState}


def oldest_queued_at(session: Session) -> float | None:
    """Return since when the oldest queued run waits; None if the queue is empty."""
    return session.scalar(select(func.min(Run.queued_at)).where(Run.state == RunState.QUEUED))


def simulated_s(session: Session) -> float:
    """Return the simulated time of all runs."""
    return session.scalar(select(func.sum(Run.t_simulated))) or 0.0


def _select() -> Select[Run, Result | None, User | None]:
    return (
        select(Run, Result, User)
        .outerjoin(Result, Result.run_id == Run.id)
        .outerjoin(User, User.id == Run.user_id)
    )


def _view(run: Run, result: Result | None, user: User | None, /, **wait: object) -> RunView:
    name, is_baseline = ("guest", False) if user is None else (user.name, user.is_baseline)
    view = RunView.from_rows(result, run, user=name, is_baseline=is_baseline, **wait)
    # Printable when it was stored by this version; not by an earlier one.
    detail = {name: _shown(value) for name, value in view.detail.items()}
    return view.model_copy(update={"detail": detail})


def _shown(value: object) -> object:
    return printable_text(value) if isinstance(value, str) else value
