"""Computing a set of runs again, with a preview of what would change before anything does.

1. `start` queues a hidden run for each chosen one (runs/recomputation/rejudged.py). At most one
   rejudgement waits for its decision.
2. The workers evaluate them after everybody's runs; each is compared as it ends.
3. `accept` replaces the results that differ, in one transaction; `discard` ends it at any time.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from sqlalchemy import case, func, select, update
from sqlalchemy.orm import Session, aliased, undefer

from seamark.sandbox.printable_text import visible_text
from seamark.server.accounts import audit
from seamark.server.accounts.audit import Actor, AuditAction
from seamark.server.administration import rejudge_choice
from seamark.server.administration.rejudge_choice import RunChoice
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.rejudgement_tables import RejudgedRun, Rejudgement
from seamark.server.database.tables import Result, Run, User
from seamark.server.runs.ending import results
from seamark.server.runs.leaderboard import best_runs
from seamark.server.runs.leaderboard.rank_preview import RankChange, RankPreview
from seamark.server.runs.recomputation import rejudged
from seamark.server.runs.recomputation.rejudged import Outcome
from seamark.server.runs.record import turns
from seamark.server.runs.record.states import FINAL, LIVE, RunKind
from seamark.server.settings import Settings
from seamark.server.storage import storage

PAGE, PAGE_MAX = 50, 200
REASON_MAX = 500  # [character]
BATCH = 200  # differences that are read at a time


class RejudgementRefused(Exception):
    """It cannot be started or decided now. The text is for the admin."""


class Decision(StrEnum):
    """What became of a rejudgement."""

    ACCEPTED = "accepted"
    DISCARDED = "discarded"


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """How many runs of a rejudgement there are, by what became of them."""

    runs: int
    live: int
    same: int
    different: int
    part: float  # 0 to 1, with that of the running ones

    @property
    def failed(self) -> int:
        """Runs without an outcome: cancelled, or the service could not compute them."""
        return self.runs - self.live - self.same - self.different


@dataclass(frozen=True, slots=True)
class RejudgementView:
    """A rejudgement as pages and the API show it."""

    row: Rejudgement
    progress: Progress


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """A run whose result is another one when it is computed again."""

    run_id: int
    user: str  # "guest" without an account
    kind: RunKind
    before: dict[str, Any]  # state, cause, digest, score
    after: dict[str, Any]
    metrics: Sequence[str]  # paths of the first that differ
    metrics_count: int
    rank: RankChange | None  # None: it concerns no rank, or is decided
    key: int  # `after` of the next page


def start(
    session: Session, actor: Actor, choice: RunChoice, reason: str, settings: Settings
) -> int:
    """Queue the chosen runs to be computed again and return the id of the rejudgement.

    Raises
    ------
    RejudgementRefused
        No run matches, there is no reason, or another rejudgement waits for its decision.
    StorageUnavailable
        There is no room for what they may record, or the data folder is away.
    """
    reason = visible_text(reason).strip()
    if not 1 <= len(reason) <= REASON_MAX:
        raise RejudgementRefused(f"Give a reason of 1 to {REASON_MAX} characters.")
    storage.require(settings)
    acquire(session, AdvisoryLock.SUBMISSION)
    waiting = session.scalar(select(Rejudgement.id).where(Rejudgement.decision.is_(None)).limit(1))
    if waiting is not None:
        raise RejudgementRefused(f"Accept or discard rejudgement {waiting} first.")
    chosen = rejudge_choice.choose(session, choice)
    if not chosen.runs:
        raise RejudgementRefused("No run matches.")
    row = Rejudgement(benchmark=choice.benchmark, reason=reason, chosen=choice.as_dict())
    row.created_by, row.created_at = actor.name[:80], time.time()
    session.add(row)
    session.flush()
    whole = select(Run).options(undefer(Run.program_parameters)).order_by(Run.id)
    originals = session.scalars(whole.where(Run.id.in_(chosen.runs))).all()
    owner = rejudged.owner_of(row.id)
    again = [rejudged.enqueue(session, run, owner, settings) for run in originals]
    session.flush()
    session.add_all(RejudgedRun(run_id=run.id, rejudgement_id=row.id) for run in again)
    turns.refresh(session, owner)
    what = {"benchmark": choice.benchmark, "runs": len(again), "reason": reason}
    audit.record(session, actor, AuditAction.REJUDGEMENT_STARTED, _target(row), what)
    return row.id


def page(
    session: Session, *, after: int | None = None, limit: int = PAGE
) -> tuple[list[RejudgementView], int | None]:
    """Return rejudgements before `after`, newest first, and where the following page begins."""
    limit = max(1, min(limit, PAGE_MAX))
    query = select(Rejudgement).order_by(Rejudgement.id.desc()).limit(limit + 1)
    if after is not None:
        query = query.where(Rejudgement.id < after)
    rows = session.scalars(query).all()
    views = [RejudgementView(row, _progress(session, row.id)) for row in rows[:limit]]
    return views, rows[limit - 1].id if len(rows) > limit else None


def show(session: Session, rejudgement_id: int) -> RejudgementView | None:
    """Return a rejudgement, or None."""
    row = session.get(Rejudgement, rejudgement_id)
    return None if row is None else RejudgementView(row, _progress(session, row.id))


def differences(
    session: Session, row: Rejudgement, *, after: int | None = None, limit: int = PAGE
) -> list[Difference]:
    """Return runs whose result differs, in their order, after the key of the previous page."""
    original, again = aliased(Run), aliased(Run)
    query = (
        select(RejudgedRun, original.id, original.kind, original.user_id, User.name)
        .join(again, again.id == RejudgedRun.run_id)
        .join(original, original.id == again.rejudges)
        .outerjoin(User, User.id == original.user_id)
        .where(RejudgedRun.rejudgement_id == row.id, RejudgedRun.outcome == Outcome.DIFFERENT)
        .where(original.deleted_at.is_(None))
    )
    if after is not None:
        query = query.where(RejudgedRun.run_id > after)
    rows = session.execute(query.order_by(RejudgedRun.run_id).limit(max(1, limit))).all()
    preview = None if row.decision is not None or not rows else _preview(session, row)
    return [
        Difference(
            run_id=run_id,
            user=name or "guest",
            kind=RunKind(kind),
            before=each.before or {},
            after=each.after or {},
            metrics=each.metrics or [],
            metrics_count=each.metrics_count,
            rank=None if preview is None or user_id is None else preview.of(user_id),
            key=each.run_id,
        )
        for each, run_id, kind, user_id, name in rows
    ]


def all_differences(session: Session, row: Rejudgement) -> Iterator[Difference]:
    """Yield all differences, at most `RUNS_MAX`."""
    after: int | None = None
    while differing := differences(session, row, after=after, limit=BATCH):
        yield from differing
        after = differing[-1].key


def accept(session: Session, actor: Actor, rejudgement_id: int) -> None:
    """Replace the results that differ; the earlier ones are kept.

    Raises
    ------
    RejudgementRefused
        It is decided, or not all runs have ended.
    """
    row = _undecided(session, rejudgement_id)
    progress = _progress(session, row.id)
    if progress.live:
        raise RejudgementRefused("Wait until all runs have been computed again.")
    original, again = aliased(Run), aliased(Run)
    query = (
        select(RejudgedRun, again, original)
        .join(again, again.id == RejudgedRun.run_id)
        .join(original, original.id == again.rejudges)
        .where(RejudgedRun.rejudgement_id == row.id, RejudgedRun.outcome == Outcome.DIFFERENT)
        .where(original.deleted_at.is_(None))
        .with_for_update(of=original)
    )
    ranked, replaced = set[int](), 0
    for each, run, old in session.execute(query).all():
        rejudged.replace(session, run, old, each)
        replaced += 1
        if old.kind == RunKind.RANKED and old.user_id is not None:
            ranked.add(old.user_id)
    for user_id in sorted(ranked):
        best_runs.refresh(session, row.benchmark, user_id)
    counts = {"replaced": replaced, "same": progress.same, "failed": progress.failed}
    _decide(session, actor, row, Decision.ACCEPTED)
    audit.record(session, actor, AuditAction.REJUDGEMENT_ACCEPTED, _target(row), counts)


def discard(session: Session, actor: Actor, rejudgement_id: int) -> None:
    """End a rejudgement without changing a result; what still waits or runs is cancelled.

    Raises
    ------
    RejudgementRefused
        It is decided.
    """
    row = _undecided(session, rejudgement_id)
    its = Run.owner == rejudged.owner_of(row.id)
    live = session.scalars(select(Run.id).where(its, Run.state.in_(LIVE)).order_by(Run.id)).all()
    cancelled = sum(results.cancel(session, run_id) is not None for run_id in live)
    gone = update(Run).where(its, Run.state.in_(FINAL), Run.data_deleted_at.is_(None))
    session.execute(gone.values(data_deleted_at=time.time(), data_bytes=0, data_measured=True))
    _decide(session, actor, row, Decision.DISCARDED)
    what = {"cancelled_runs": cancelled}
    audit.record(session, actor, AuditAction.REJUDGEMENT_DISCARDED, _target(row), what)


def _undecided(session: Session, rejudgement_id: int) -> Rejudgement:
    """Return a rejudgement, locked, so that of two decisions at once only one is made."""
    query = select(Rejudgement).where(Rejudgement.id == rejudgement_id).with_for_update()
    row = session.scalars(query).one()
    if row.decision is not None:
        raise RejudgementRefused(f"Rejudgement {row.id} has already been {row.decision}.")
    return row


def _decide(session: Session, actor: Actor, row: Rejudgement, decision: Decision) -> None:
    row.decision, row.decided_by, row.decided_at = decision, actor.name[:80], time.time()
    session.flush()


def _preview(session: Session, row: Rejudgement) -> RankPreview:
    return RankPreview(session, row.benchmark, dict(_new_scores(session, row)))


def _new_scores(session: Session, row: Rejudgement) -> Iterator[tuple[int, float | None]]:
    """Yield the runs whose results differ, with the scores that they would be ranked by."""
    new, old = aliased(Result), aliased(Result)
    by_benchmark = old.metrics["not_ranked"].as_string()
    query = (
        select(Run.rejudges, new.score, new.rankable, old.not_ranked, by_benchmark)
        .join(RejudgedRun, RejudgedRun.run_id == Run.id)
        .join(new, new.run_id == Run.id)
        .outerjoin(old, old.run_id == Run.rejudges)
        .where(RejudgedRun.rejudgement_id == row.id, RejudgedRun.outcome == Outcome.DIFFERENT)
    )
    for run_id, score, rankable, not_ranked, rule in session.execute(query):
        if run_id is not None:  # as `rejudged.replace` decides it
            refused = not_ranked is not None and rule is None
            yield run_id, score if rankable and not refused else None


def _progress(session: Session, rejudgement_id: int) -> Progress:
    live = case((Run.state.in_(LIVE), 1), else_=0)
    of = (case((RejudgedRun.outcome == outcome, 1), else_=0) for outcome in Outcome)
    done = case((Run.state.in_(FINAL), 1.0), else_=Run.progress)
    sums = [func.coalesce(func.sum(each), 0) for each in (live, *of, done)]
    query = select(func.count(), *sums).select_from(RejudgedRun)
    query = query.join(Run, Run.id == RejudgedRun.run_id)
    row = session.execute(query.where(RejudgedRun.rejudgement_id == rejudgement_id)).one()
    runs, waiting, same, different, part = row
    return Progress(
        runs=runs, live=waiting, same=same, different=different, part=part / runs if runs else 1.0
    )


def _target(row: Rejudgement) -> str:
    return f"rejudgement {row.id}"
