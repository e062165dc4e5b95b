"""The leaderboard: `best` rows are kept up to date, so a page costs the same at any depth.

A user has one row per benchmark: the best published ranked run.
"""

import math
from dataclasses import dataclass
from typing import Any, Self

from sqlalchemy import ColumnElement, Select, and_, delete, func, or_, select, update
from sqlalchemy.orm import Session

from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.tables import Best, Result, Run, User
from seamark.server.runs.quota import ranked_ended
from seamark.server.runs.states import RunKind, RunState


@dataclass(frozen=True, slots=True)
class Cursor:
    """The sort key of the last row of a page."""

    score: float
    reached_at: float
    user_id: int

    def text(self) -> str:
        """Return a text for a URL; `parse` reads it back exactly."""
        return f"{self.score.hex()}_{self.reached_at.hex()}_{self.user_id}"

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read a cursor; raises ValueError if it is none."""
        score, reached_at, user_id = text.split("_")
        cursor = cls(float.fromhex(score), float.fromhex(reached_at), int(user_id))
        if not (math.isfinite(cursor.score + cursor.reached_at) and abs(cursor.user_id) < 2**53):
            raise ValueError("no row of a leaderboard has this key")
        return cursor


_ORDER = (Best.score.desc(), Best.reached_at, Best.user_id)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rank:
    """One row of the leaderboard."""

    rank: int
    shared_rank: int  # rank of the first row of the chain of ties that this row belongs to
    tied: bool  # its interval overlaps that of the row above: the order of the two may be chance
    user_id: int
    user: str
    is_baseline: bool
    run_id: int
    benchmark: str
    config: dict[str, Any]
    controller: str
    program_name: str | None
    title: str
    score: float
    low: float
    high: float
    level_held: float | None
    submissions: int  # ranked, of this user in this benchmark
    reached_at: float

    @property
    def cursor(self) -> Cursor:
        """Where to go on after this row."""
        return Cursor(self.score, self.reached_at, self.user_id)


def page(
    session: Session, benchmark: str, *, after: Cursor | None = None, limit: int | None = 50
) -> list[Rank]:
    """Return the next rows of one benchmark, best first; equal scores in order of time.

    Without a limit, all that follow.
    """
    query = _rows(benchmark).order_by(*_ORDER).limit(limit)
    first, shared_rank, above_low = 1, 1, None
    if after is not None:
        query = query.where(~_not_below(after))
        first = size(session, benchmark, at_or_above=after) + 1
        shared_rank = _shared_rank(session, benchmark, after)
        above_low = _low(session, benchmark, after.user_id)
    ranks: list[Rank] = []
    for rank, (best, run, user) in enumerate(session.execute(query), start=first):
        tied = above_low is not None and best.score_high >= above_low
        shared_rank = shared_rank if tied else rank
        ranks.append(_rank(best, run, user, rank=rank, shared_rank=shared_rank, tied=tied))
        above_low = best.score_low
    return ranks


def rank_of(session: Session, benchmark: str, user_id: int) -> Rank | None:
    """Return a user's own rank, or None without one."""
    found = session.execute(_rows(benchmark).where(Best.user_id == user_id)).one_or_none()
    if found is None:
        return None
    best, run, user = found
    here = Cursor(best.score, best.reached_at, best.user_id)
    rank = size(session, benchmark, at_or_above=here)
    shared_rank = _shared_rank(session, benchmark, here)
    return _rank(best, run, user, rank=rank, shared_rank=shared_rank, tied=shared_rank < rank)


def size(session: Session, benchmark: str, *, at_or_above: Cursor | None = None) -> int:
    """Return how many rows a benchmark has, all or down to a cursor."""
    query = select(func.count()).select_from(Best).where(Best.benchmark == benchmark)
    if at_or_above is not None:
        query = query.where(_not_below(at_or_above))
    return session.scalar(query) or 0


def refresh(session: Session, benchmark: str, user_id: int) -> None:
    """Update the `best` row of one user, in the transaction that changed a run."""
    acquire(session, AdvisoryLock.LEADERBOARD)
    session.execute(delete(Best).where(Best.benchmark == benchmark, Best.user_id == user_id))
    candidates = _candidates().where(Run.benchmark == benchmark, Run.user_id == user_id)
    found = session.execute(candidates.limit(1)).one_or_none()
    if found is not None:
        session.add(_best(*found))
    session.flush()
    _count(session, Best.benchmark == benchmark, Best.user_id == user_id)


def recount(session: Session, run_id: int) -> None:
    """Update the number of submissions in the row of a run's user, in the transaction that ends it.

    The run itself need not be public: the best of many tries is a lucky one, shown or not.
    """
    run = session.get_one(Run, run_id)
    if run.kind == RunKind.RANKED and run.user_id is not None:
        acquire(session, AdvisoryLock.LEADERBOARD)
        _count(session, Best.benchmark == run.benchmark, Best.user_id == run.user_id)


def rebuild(session: Session) -> int:
    """Compute all `best` rows from the runs and return their number.

    They are the rows that `refresh` keeps, unless somebody changed the tables by hand.
    """
    acquire(session, AdvisoryLock.LEADERBOARD)
    session.execute(delete(Best))
    seen: set[tuple[str, int | None]] = set()
    for run, result in session.execute(_candidates()):
        if (run.benchmark, run.user_id) not in seen:
            seen.add((run.benchmark, run.user_id))
            session.add(_best(run, result))
    session.flush()
    _count(session)
    return len(seen)


def _count(session: Session, *rows: ColumnElement[bool]) -> None:
    """Store in rows of `best` how many ranked runs of their user and benchmark have ended."""
    ended = (
        select(func.count())
        .select_from(Run)
        .where(Run.user_id == Best.user_id, Run.benchmark == Best.benchmark, ranked_ended())
    )
    session.execute(update(Best).where(*rows).values(submissions=ended.scalar_subquery()))


def _candidates() -> Select[Run, Result]:
    """Select what may be ranked, the better first; of equal scores the earlier."""
    return (
        select(Run, Result)
        .join(Result, Result.run_id == Run.id)
        .where(Run.state == RunState.SUCCEEDED, Run.kind == RunKind.RANKED, Run.public)
        .where(Run.user_id.is_not(None), Result.rankable)
        .order_by(Result.score.desc(), Run.finished_at, Run.id)
    )


def _best(run: Run, result: Result) -> Best:
    score = result.score
    return Best(
        benchmark=run.benchmark,
        user_id=run.user_id,
        run_id=run.id,
        score=score,
        score_low=score if result.score_low is None else result.score_low,
        score_high=score if result.score_high is None else result.score_high,
        level_held=result.level_held,
        reached_at=run.finished_at,
    )


def _rows(benchmark: str) -> Select[Best, Run, User]:
    return (
        select(Best, Run, User)
        .join(Run, Run.id == Best.run_id)
        .join(User, User.id == Best.user_id)
        .where(Best.benchmark == benchmark)
    )


def _not_below(cursor: Cursor) -> ColumnElement[bool]:
    same = Best.score == cursor.score
    return or_(
        Best.score > cursor.score,
        and_(same, Best.reached_at < cursor.reached_at),
        and_(same, Best.reached_at == cursor.reached_at, Best.user_id <= cursor.user_id),
    )


def _shared_rank(session: Session, benchmark: str, here: Cursor) -> int:
    """Return the rank of the first row of the chain of ties that ends at a cursor."""
    above = func.lag(Best.score_low).over(order_by=_ORDER)
    apart = or_(above.is_(None), Best.score_high < above)
    rank = func.row_number().over(order_by=_ORDER)
    rows = (
        select(rank.label("rank"), apart.label("apart"))
        .where(Best.benchmark == benchmark, _not_below(here))
        .subquery()
    )
    return session.scalar(select(func.max(rows.c.rank)).where(rows.c.apart)) or 1


def _low(session: Session, benchmark: str, user_id: int) -> float | None:
    return session.scalar(
        select(Best.score_low).where(Best.benchmark == benchmark, Best.user_id == user_id)
    )


def _rank(best: Best, run: Run, user: User, *, rank: int, shared_rank: int, tied: bool) -> Rank:
    return Rank(
        rank=rank,
        shared_rank=shared_rank,
        tied=tied,
        user_id=user.id,
        user=user.name,
        is_baseline=user.is_baseline,
        run_id=best.run_id,
        benchmark=run.benchmark,
        config=run.config,
        controller=run.controller,
        program_name=run.program_name,
        title=run.title,
        score=best.score,
        low=best.score_low,
        high=best.score_high,
        level_held=best.level_held,
        submissions=best.submissions,
        reached_at=best.reached_at,
    )
