"""Runs as pages and the API show them: values, not rows, with the hidden seed left out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from sqlalchemy import Select, select
from sqlalchemy.orm import Session, defer

from seamark.server.accounts.permissions import Viewer
from seamark.server.database.tables import Result, Run, User
from seamark.server.runs import wait_estimate
from seamark.server.runs.states import RunState
from seamark.server.settings import Settings

LIMIT_MAX = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class RunView:
    """All that is shown of a run. `metrics` and `manifest` are None in lists."""

    id: int
    user_id: int | None
    guest: str | None
    user: str  # "guest" without an account
    is_baseline: bool
    benchmark: str
    kind: str
    config: dict[str, Any]
    seed: int | None  # None: ranked, on hidden seeds
    trials: int
    controller: str
    program_sha256: str | None
    program_name: str | None
    language: str | None
    title: str
    notes: str
    rerun_of: int | None
    state: RunState
    cause: str | None
    detail: dict[str, Any]  # title, sentence, remedy, traceback, log_tail, t_reached; when failed
    queued_at: float
    started_at: float | None
    finished_at: float | None
    attempt: int
    progress: float  # 0 to 1
    t_simulated: float  # [s] over all trials
    isolation: str | None
    public: bool
    published_at: float | None
    score: float | None
    score_low: float | None
    score_high: float | None
    level_held: float | None
    rankable: bool | None  # False: the benchmark's rules keep it off the leaderboard
    digest: str | None
    metrics: dict[str, Any] | None = None
    manifest: dict[str, Any] | None = None
    position: int | None = None  # in the line, 1 is next; when queued
    estimate_s: float | None = None  # [s] until its end; None: nothing to go by
    why_waiting: str | None = None

    @property
    def version(self) -> str:
        """A text that changes whenever the view does: for an ETag."""
        parts = (self.state, self.attempt, self.public, round(self.progress, 3), self.position)
        return "-".join(str(part) for part in parts)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunFilter:
    """Which runs a list shows; what is left out does not narrow it."""

    which: Literal["mine", "public", "all"] = "mine"
    user: str | None = None
    states: Sequence[RunState] = ()
    benchmark: str | None = None
    kind: str | None = None


@dataclass(frozen=True, slots=True)
class RunPage:
    """A part of a list; `next` is the `after` of the following part, None at the end."""

    runs: list[RunView]
    next: int | None


def show(session: Session, run_id: int, settings: Settings | None = None) -> RunView | None:
    """Return one run with everything, or None. With settings also its place in the line."""
    found = session.execute(_select().where(Run.id == run_id)).one_or_none()
    if found is None:
        return None
    run, result, user = found
    view = _view(run, result, user)
    if result is not None:
        view = replace(view, metrics=result.metrics, manifest=result.manifest)
    if settings is None or view.state.final:
        return view
    wait = wait_estimate.wait_of(session, run, settings)
    return replace(view, position=wait.position, estimate_s=wait.estimate_s, why_waiting=wait.why)


def page(
    session: Session,
    viewer: Viewer,
    wanted: RunFilter,
    *,
    after: int | None = None,
    limit: int = 50,
) -> RunPage:
    """Return runs, newest first: one's own, the public ones, or (for an admin) all."""
    query = _select()
    if wanted.which == "public":
        query = query.where(Run.public)
    elif wanted.which == "mine" or not viewer.is_admin:
        query = query.where(Run.owner == (viewer.owner or ""))
    if wanted.user is not None:
        query = query.where(User.name_key == wanted.user.casefold())
    if wanted.states:
        query = query.where(Run.state.in_(wanted.states))
    if wanted.benchmark is not None:
        query = query.where(Run.benchmark == wanted.benchmark)
    if wanted.kind is not None:
        query = query.where(Run.kind == wanted.kind)
    if after is not None:
        query = query.where(Run.id < after)
    limit = max(1, min(limit, LIMIT_MAX))
    # A list shows neither: parsing the metrics of large grids would take most of its time.
    query = query.options(defer(Result.metrics), defer(Result.manifest))
    found = session.execute(query.order_by(Run.id.desc()).limit(limit + 1)).all()
    views = [_view(*row) for row in found[:limit]]
    return RunPage(views, views[-1].id if len(found) > limit else None)


def _select() -> Select[Run, Result | None, User | None]:
    return (
        select(Run, Result, User)
        .outerjoin(Result, Result.run_id == Run.id)
        .outerjoin(User, User.id == Run.user_id)
    )


_SAME = (
    *("id", "user_id", "guest", "benchmark", "kind", "config", "seed", "trials", "controller"),
    *("program_sha256", "program_name", "language", "title", "notes", "rerun_of", "cause"),
    *("detail", "queued_at", "started_at", "finished_at", "attempt", "progress", "t_simulated"),
    *("isolation", "public", "published_at"),
)
_OF_RESULT = ("score", "score_low", "score_high", "level_held", "rankable", "digest")


def _view(run: Run, result: Result | None, user: User | None) -> RunView:
    same: dict[str, Any] = {name: getattr(run, name) for name in _SAME}
    of_result: dict[str, Any] = {name: getattr(result, name, None) for name in _OF_RESULT}
    return RunView(
        **same,
        **of_result,
        state=RunState(run.state),
        user=user.name if user is not None else "guest",
        is_baseline=user is not None and user.is_baseline,
    )
