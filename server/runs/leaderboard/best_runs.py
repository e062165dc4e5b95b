"""The rows of the leaderboard: of each user, and of each of their methods, kept up to date.

Whoever changes what a rank follows from calls `refresh` or `recount` in the same transaction.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from sqlalchemy import ColumnElement, delete, func, select, union, update
from sqlalchemy.orm import Session

from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.tables import Best, BestMethod, BoardRow, Result, Run, User
from seamark.server.runs.leaderboard import leaderboard, rank_history, score_counts
from seamark.server.runs.leaderboard.board_rows import Cursor
from seamark.server.runs.leaderboard.per import Per
from seamark.server.runs.record import method_names, solutions
from seamark.server.runs.record.states import RunKind, RunState, ranked_ended
from seamark.server.runs.record.trial_scores import error_of_score
from seamark.sim import registry

LABEL_MAX = 40  # [character] of a vehicle or tracker
BATCH = 200  # runs that are loaded, and users that are completed, at a time


def refresh(session: Session, benchmark: str, user_id: int) -> None:
    """Update the rows of one user, in the transaction that changed a run."""
    acquire(session, AdvisoryLock.LEADERBOARD)
    _compute(session, benchmark, user_id)
    _record_rank(session, benchmark, user_id)


def recount(session: Session, run_id: int) -> None:
    """Update the number of submissions of a run's user, in the transaction that ends the run.

    The run itself need not be public: the best of many tries is a lucky one, shown or not.
    """
    run = session.get_one(Run, run_id)
    if run.kind == RunKind.RANKED and run.user_id is not None:
        acquire(session, AdvisoryLock.LEADERBOARD)
        _count_submissions(session, (run.benchmark, run.user_id))


def complete(session: Session) -> int:
    """Compute rows of users of whom an earlier version stored some in part; return how many users.

    Such a row has no metrics.
    """
    acquire(session, AdvisoryLock.LEADERBOARD)
    partial = (
        select(per.table.benchmark, per.table.user_id).where(per.table.metrics.is_(None))
        for per in Per
    )
    users = session.execute(union(*partial).limit(BATCH)).all()
    for benchmark, user_id in users:
        _compute(session, benchmark, user_id)
    return len(users)


def rebuild(session: Session) -> int:
    """Compute all rows from the runs and return the number of those of `best`.

    They are the rows that `refresh` keeps, unless somebody changed the tables by hand.
    """
    acquire(session, AdvisoryLock.LEADERBOARD)
    for per in Per:
        session.execute(delete(per.table))
    number, counts = 0, score_counts.Counts()
    for per, row in _rows(session):
        session.add(row)
        number += per is Per.PERSON
        _count(counts, per, row, 1)
    score_counts.replace_all(session, counts)
    _count_submissions(session)
    return number


def _compute(session: Session, benchmark: str, user_id: int) -> None:
    """Compute the rows of one user anew."""
    counts = score_counts.Counts()
    for per in Per:
        for old in session.scalars(select(per.table).where(*per.of_user(benchmark, user_id))):
            _count(counts, per, old, -1)
            session.delete(old)
    session.flush()
    for per, new in _rows(session, Run.benchmark == benchmark, Run.user_id == user_id):
        _count(counts, per, new, 1)
        session.add(new)
    session.flush()
    score_counts.change(session, counts)
    _count_submissions(session, (benchmark, user_id))


def _count(counts: score_counts.Counts, per: Per, row: BoardRow, by: int) -> None:
    if not row.is_baseline:
        counts[row.benchmark, score_counts.key_of(leaderboard.estimate_of(row)), per] += by


def _count_submissions(session: Session, user: tuple[str, int] | None = None) -> None:
    """Store in rows how many ranked runs of their user and benchmark have ended.

    `user` is the benchmark and the user whose rows these are; None: all.
    """
    for per in Per:
        table = per.table
        ended = (
            select(func.count())
            .select_from(Run)
            .where(Run.user_id == table.user_id, Run.benchmark == table.benchmark, ranked_ended())
        )
        change = update(table).where(*(per.of_user(*user) if user else ()))
        session.execute(change.values(submissions=ended.scalar_subquery()))


def _record_rank(session: Session, benchmark: str, user_id: int) -> None:
    """Add a point to the history of a user's rank."""
    best = session.get(Best, (benchmark, user_id))
    if best is None:
        rank_history.record(session, user_id, benchmark, rank=None, score=None)
    elif not best.is_baseline and not _is_anonymous(session, best):
        here = Cursor(best.score, best.reached_at, best.run_id)
        number = leaderboard.count_down_to(session, benchmark, here)
        rank_history.record(session, user_id, benchmark, rank=number, score=best.score)


def _is_anonymous(session: Session, best: Best) -> bool:
    return bool(session.scalar(select(Run.anonymous).where(Run.id == best.run_id)))


class _Chosen(NamedTuple):
    """A run that has a row of its own."""

    run_id: int
    method: str  # `method_names.key`
    is_baseline: bool
    is_best: bool  # of all methods of its user


def _rows(session: Session, *which: ColumnElement[bool]) -> Iterator[tuple[Per, BoardRow]]:
    """Yield the rows of users whose runs meet some conditions."""
    chosen = _chosen(session, *which)
    for at in range(0, len(chosen), BATCH):
        batch = chosen[at : at + BATCH]
        query = select(Run, Result).join(Result, Result.run_id == Run.id)
        query = query.where(Run.id.in_([each.run_id for each in batch]))
        found = {run.id: (run, result) for run, result in session.execute(query)}
        for each in batch:
            values = _values(*found[each.run_id])
            values["is_baseline"] = each.is_baseline
            yield Per.METHOD, BestMethod(method=each.method, **values)
            if each.is_best:
                yield Per.PERSON, Best(**values)


def _chosen(session: Session, *which: ColumnElement[bool]) -> list[_Chosen]:
    """Return the best run of each method of each user; of a baseline the best of all."""
    query = (
        select(Run.id, Run.benchmark, User.id, Run.method, User.is_baseline)
        .join(Result, Result.run_id == Run.id)
        .join(User, User.id == Run.user_id)
        .where(Run.state == RunState.SUCCEEDED, Run.kind == RunKind.RANKED, Run.public)
        .where(Result.rankable, *which)
        .order_by(Result.score.desc(), Run.finished_at, Run.id)
    )
    chosen: list[_Chosen] = []
    users, methods = set[tuple[str, int]](), set[tuple[str, int, str]]()
    for run_id, benchmark, user_id, name, is_baseline in session.execute(query):
        user, method = (benchmark, user_id), "" if is_baseline else method_names.key(name)
        if (*user, method) not in methods:
            chosen.append(_Chosen(run_id, method, is_baseline, user not in users))
        users.add(user)
        methods.add((*user, method))
    return chosen


def _values(run: Run, result: Result) -> dict[str, Any]:
    """Return the columns that a row has of its run."""
    score = result.score
    error, degrees = error_of_score(run.benchmark, result.metrics)
    return {
        "benchmark": run.benchmark,
        "user_id": run.user_id,
        "run_id": run.id,
        "score": score,
        "score_low": score if result.score_low is None else result.score_low,
        "score_high": score if result.score_high is None else result.score_high,
        "standard_error": error,
        "degrees": degrees,
        "level_held": result.level_held,
        "reached_at": run.finished_at,
        "language": run.language or "",
        "vehicle": str(run.config.get("vehicle", ""))[:LABEL_MAX],
        "tracker": solutions.built_in_tracker(run)[:LABEL_MAX],
        "metrics": _board_values(run.benchmark, result.metrics),
    }


def _board_values(benchmark: str, metrics: Mapping[str, Any] | None) -> dict[str, float]:
    if metrics is None or benchmark not in registry.BENCHMARKS:
        return {}
    return registry.benchmark(benchmark).board_values(metrics)
