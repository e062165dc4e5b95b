"""The rows of the leaderboard: one for each user and benchmark, kept up to date.

Whoever changes what a rank follows from calls `refresh` or `recount` in the same transaction.
"""

from collections import Counter
from collections.abc import Mapping
from typing import Any

from sqlalchemy import ColumnElement, Select, delete, func, select, update
from sqlalchemy.orm import Session

from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.tables import Best, Result, Run, User
from seamark.server.runs.leaderboard import leaderboard, rank_history, score_counts
from seamark.server.runs.record import solutions
from seamark.server.runs.record.states import RunKind, RunState, ranked_ended
from seamark.server.runs.record.trial_scores import error_of_score
from seamark.sim import registry

LABEL_MAX = 40  # [character] of a vehicle or tracker
BATCH = 200  # rows whose metrics one call computes


def refresh(session: Session, benchmark: str, user_id: int) -> None:
    """Update the `best` row of one user, in the transaction that changed a run."""
    acquire(session, AdvisoryLock.LEADERBOARD)
    mine = (Best.benchmark == benchmark, Best.user_id == user_id)
    old = session.scalar(select(Best).where(*mine))
    if old is not None:
        session.delete(old)
        session.flush()
        _count_person(session, old, -1)
    candidates = _candidates().where(Run.benchmark == benchmark, Run.user_id == user_id)
    row = session.execute(candidates.limit(1)).one_or_none()
    if row is not None:
        run, result, is_baseline = row
        new = _best(run, result, is_baseline=is_baseline)
        session.add(new)
        _count_person(session, new, 1)
    session.flush()
    _count_submissions(session, *mine)
    _record_rank(session, benchmark, user_id)


def recount(session: Session, run_id: int) -> None:
    """Update the number of submissions in the row of a run's user, in the transaction that ends it.

    The run itself need not be public: the best of many tries is a lucky one, shown or not.
    """
    run = session.get_one(Run, run_id)
    if run.kind == RunKind.RANKED and run.user_id is not None:
        acquire(session, AdvisoryLock.LEADERBOARD)
        _count_submissions(session, Best.benchmark == run.benchmark, Best.user_id == run.user_id)


def complete_metrics(session: Session) -> int:
    """Compute the metrics of some rows of an earlier version, and return their number."""
    acquire(session, AdvisoryLock.LEADERBOARD)
    missing = select(Best, Result.metrics).join(Result, Result.run_id == Best.run_id)
    rows = session.execute(missing.where(Best.metrics.is_(None)).limit(BATCH)).all()
    for best, metrics in rows:
        best.metrics = _board_values(best.benchmark, metrics)
    return len(rows)


def rebuild(session: Session) -> int:
    """Compute all `best` rows from the runs and return their number.

    They are the rows that `refresh` keeps, unless somebody changed the tables by hand.
    """
    acquire(session, AdvisoryLock.LEADERBOARD)
    session.execute(delete(Best))
    seen: set[tuple[str, int | None]] = set()
    people: Counter[tuple[str, score_counts.Key]] = Counter()
    for run, result, is_baseline in session.execute(_candidates()):
        if (run.benchmark, run.user_id) not in seen:
            seen.add((run.benchmark, run.user_id))
            best = _best(run, result, is_baseline=is_baseline)
            session.add(best)
            if not is_baseline:
                people[best.benchmark, score_counts.key_of(leaderboard.estimate_of(best))] += 1
    score_counts.replace_all(session, people)
    _count_submissions(session)
    return len(seen)


def _count_submissions(session: Session, *rows: ColumnElement[bool]) -> None:
    """Store in rows of `best` how many ranked runs of their user and benchmark have ended."""
    ended = (
        select(func.count())
        .select_from(Run)
        .where(Run.user_id == Best.user_id, Run.benchmark == Best.benchmark, ranked_ended())
    )
    session.execute(update(Best).where(*rows).values(submissions=ended.scalar_subquery()))


def _record_rank(session: Session, benchmark: str, user_id: int) -> None:
    """Add a point to the history of a user's rank."""
    best = session.get(Best, (benchmark, user_id))
    if best is None:
        rank_history.record(session, user_id, benchmark, rank=None, score=None)
    elif not best.is_baseline and not _is_anonymous(session, best):
        here = leaderboard.Cursor(best.score, best.reached_at, best.run_id)
        number = leaderboard.people_down_to(session, benchmark, here)
        rank_history.record(session, user_id, benchmark, rank=number, score=best.score)


def _is_anonymous(session: Session, best: Best) -> bool:
    return bool(session.scalar(select(Run.anonymous).where(Run.id == best.run_id)))


def _count_person(session: Session, best: Best, by: int) -> None:
    if not best.is_baseline:
        key = score_counts.key_of(leaderboard.estimate_of(best))
        score_counts.change(session, best.benchmark, key, by)


def _candidates() -> Select[Run, Result, bool]:
    """Select what may be ranked, the better first; of equal scores the earlier."""
    return (
        select(Run, Result, User.is_baseline)
        .join(Result, Result.run_id == Run.id)
        .join(User, User.id == Run.user_id)
        .where(Run.state == RunState.SUCCEEDED, Run.kind == RunKind.RANKED, Run.public)
        .where(Run.user_id.is_not(None), Result.rankable)
        .order_by(Result.score.desc(), Run.finished_at, Run.id)
    )


def _best(run: Run, result: Result, is_baseline: bool) -> Best:
    score = result.score
    error, degrees = error_of_score(run.benchmark, result.metrics)
    return Best(
        benchmark=run.benchmark,
        user_id=run.user_id,
        run_id=run.id,
        score=score,
        score_low=score if result.score_low is None else result.score_low,
        score_high=score if result.score_high is None else result.score_high,
        standard_error=error,
        degrees=degrees,
        is_baseline=is_baseline,
        level_held=result.level_held,
        reached_at=run.finished_at,
        language=run.language or "",
        vehicle=str(run.config.get("vehicle", ""))[:LABEL_MAX],
        tracker=solutions.built_in_tracker(run)[:LABEL_MAX],
        metrics=_board_values(run.benchmark, result.metrics),
    )


def _board_values(benchmark: str, metrics: Mapping[str, Any] | None) -> dict[str, float]:
    if metrics is None or benchmark not in registry.BENCHMARKS:
        return {}
    return registry.benchmark(benchmark).board_values(metrics)
