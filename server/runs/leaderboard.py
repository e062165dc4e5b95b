"""The leaderboard: `best` rows are kept up to date, so a page costs the same at any depth.

A user has one row per benchmark: the best published ranked run.
"""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, Self

from sqlalchemy import (
    ColumnElement,
    Row,
    Select,
    and_,
    delete,
    func,
    or_,
    select,
    union_all,
    update,
)
from sqlalchemy.orm import Session

from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.tables import IS_BASELINE, Best, Result, Run, User
from seamark.server.runs import anonymity, board_metrics, rank_history, score_counts, solutions
from seamark.server.runs.quota import ranked_ended
from seamark.server.runs.ranking import Estimate, Population
from seamark.server.runs.states import RunKind, RunState
from seamark.server.runs.trial_scores import error_of_score
from seamark.sim.benchmarks.benchmark import Benchmark

LABEL_MAX = 40  # [character] of a vehicle or tracker


@dataclass(frozen=True, slots=True)
class Cursor:
    """The sort key of the last row of a page."""

    score: float
    reached_at: float
    run_id: int  # not the user, who may be anonymous

    def text(self) -> str:
        """Return a text for a URL; `parse` reads it back exactly."""
        return f"{self.score.hex()}_{self.reached_at.hex()}_{self.run_id}"

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read a cursor; raises ValueError if it is none."""
        score, reached_at, run_id = text.split("_")
        cursor = cls(float.fromhex(score), float.fromhex(reached_at), int(run_id))
        if not (math.isfinite(cursor.score + cursor.reached_at) and abs(cursor.run_id) < 2**53):
            raise ValueError("no row of a leaderboard has this key")
        return cursor


_ORDER = (Best.score.desc(), Best.reached_at, Best.run_id)
# What a `Rank` has of its rows, by its names. Columns alone: objects of the ORM take longer.
_COLUMNS = (
    *(Best.user_id, Best.run_id, Best.is_baseline, Best.score, Best.level_held, Best.submissions),
    *(Best.reached_at, Best.language, Best.vehicle, Best.tracker, Best.metrics),
    *(Best.score_low.label("low"), Best.score_high.label("high")),
    *(Run.benchmark, Run.config, Run.controller, Run.program_name, Run.title, Run.notes),
    Run.anonymous,
    *(User.name.label("user"), User.affiliation),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rank:
    """One row of the leaderboard.

    A baseline has no rank: it is a mark on the scale, and moves nobody down.
    """

    rank: int | None  # by the score; equal scores in order of time
    rank_low: int | None  # the best and the worst rank that are compatible with all scores,
    rank_high: int | None  # see server/runs/ranking.py
    user_id: int
    user: str
    anonymous: bool  # then `user` is no name
    is_baseline: bool
    run_id: int
    benchmark: str
    config: dict[str, Any]
    controller: str
    program_name: str | None
    title: str
    notes: str  # of the run: how its author describes the method
    affiliation: str  # of the user
    language: str  # empty: a built-in solution
    vehicle: str
    tracker: str
    metrics: Mapping[str, float]  # `Benchmark.board_metrics`
    score: float
    low: float
    high: float
    level_held: float | None
    submissions: int  # ranked, of this user in this benchmark
    reached_at: float

    @property
    def cursor(self) -> Cursor:
        """Where to go on after this row."""
        return Cursor(self.score, self.reached_at, self.run_id)


def page(
    session: Session,
    benchmark: str,
    *,
    after: Cursor | None = None,
    limit: int = 50,
    people: Population | None = None,
) -> list[Rank]:
    """Return the next rows of one benchmark, best first; equal scores in order of time.

    `people` are those of the leaderboard, if the caller has them; here and below.
    """
    query = _rows(benchmark).order_by(*_ORDER).limit(limit)
    number = 0
    if after is not None:
        query = query.where(*_below(after))
        number = people_down_to(session, benchmark, after)
    people = score_counts.population(session, benchmark) if people is None else people
    ranks: list[Rank] = []
    for row in session.execute(query):
        number += not row.is_baseline
        ranks.append(_rank(row, number, people))
    return ranks


def leaders(session: Session, benchmark: Benchmark, count: int) -> list[Rank]:
    """Return the first rows of a leaderboard, without baselines and without ranges of ranks."""
    return _leaders(session.execute(_leading(benchmark, count)), count)


def leaders_of(
    session: Session, benchmarks: Sequence[Benchmark], count: int
) -> dict[str, list[Rank]]:
    """Return name -> `leaders` of some benchmarks, by one statement."""
    each = (select(_leading(benchmark, count).subquery()) for benchmark in benchmarks)
    rows = sorted(session.execute(union_all(*each)), key=_order)
    return {
        benchmark.name: _leaders((row for row in rows if row.benchmark == benchmark.name), count)
        for benchmark in benchmarks
    }


@dataclass(frozen=True, slots=True)
class Key:
    """What a row is filtered and sorted by; `number` is its rank, or that of the row above."""

    number: int
    user_id: int
    run_id: int
    is_baseline: bool
    score: float
    reached_at: float
    language: str
    vehicle: str
    tracker: str
    metrics: Mapping[str, float]

    @classmethod
    def of(cls, number: int, row: Row[*tuple[Any, ...]]) -> Self:
        """Return the key of a row that `_keys` selects."""
        return cls(**row._asdict() | {"number": number, "metrics": row.metrics or {}})

    @property
    def cursor(self) -> Cursor:
        """Where to go on after this row."""
        return Cursor(self.score, self.reached_at, self.run_id)


def keys(session: Session, benchmark: str, *, after: Cursor | None = None, limit: int) -> list[Key]:
    """Return the keys of the next rows, best first: a fraction of the work of whole rows."""
    query = _keys(benchmark).order_by(*_ORDER).limit(limit)
    number = 0
    if after is not None:
        query = query.where(*_below(after))
        number = people_down_to(session, benchmark, after)
    found: list[Key] = []
    for row in session.execute(query):
        number += not row.is_baseline
        found.append(Key.of(number, row))
    return found


def baseline_keys(session: Session, benchmark: str, *, after: Cursor | None = None) -> list[Key]:
    """Return the keys of all baselines, or of those after a row, best first. They are few.

    Sorted here: with ORDER BY, SQLite would look for them among all rows in that order.
    """
    rows = session.execute(_keys(benchmark).where(IS_BASELINE))
    found = [Key.of(0, row) for row in rows]
    found.sort(key=lambda key: place(key.cursor))
    return [key for key in found if after is None or place(key.cursor) > place(after)]


def rows_of(
    session: Session, benchmark: str, chosen: Sequence[Key], people: Population | None = None
) -> list[Rank]:
    """Return the whole rows of some keys, in their order."""
    if not chosen:
        return []
    query = _rows(benchmark).where(Best.user_id.in_([key.user_id for key in chosen]))
    found = {row.user_id: row for row in session.execute(query)}
    people = score_counts.population(session, benchmark) if people is None else people
    return [_rank(found[key.user_id], key.number, people) for key in chosen if key.user_id in found]


def rank_of(
    session: Session, benchmark: str, user_id: int, people: Population | None = None
) -> Rank | None:
    """Return a user's own row, or None without one."""
    found = session.execute(_rows(benchmark).where(Best.user_id == user_id)).one_or_none()
    if found is None:
        return None
    here = Cursor(found.score, found.reached_at, found.run_id)
    number = people_down_to(session, benchmark, here)
    people = score_counts.population(session, benchmark) if people is None else people
    return _rank(found, number, people)


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
    found = session.execute(candidates.limit(1)).one_or_none()
    if found is not None:
        run, result, is_baseline = found
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


def complete_metrics(session: Session, limit: int = 200) -> int:
    """Compute the metrics of some rows of an earlier version, and return their number."""
    acquire(session, AdvisoryLock.LEADERBOARD)
    missing = select(Best, Result.metrics).join(Result, Result.run_id == Best.run_id)
    found = session.execute(missing.where(Best.metrics.is_(None)).limit(limit)).all()
    for best, metrics in found:
        best.metrics = board_metrics.values(best.benchmark, metrics)
    return len(found)


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
                people[best.benchmark, score_counts.key_of(_estimate(best))] += 1
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
        here = Cursor(best.score, best.reached_at, best.run_id)
        number = people_down_to(session, benchmark, here)
        rank_history.record(session, user_id, benchmark, rank=number, score=best.score)


def _is_anonymous(session: Session, best: Best) -> bool:
    return bool(session.scalar(select(Run.anonymous).where(Run.id == best.run_id)))


def _count_person(session: Session, best: Best, by: int) -> None:
    if not best.is_baseline:
        key = score_counts.key_of(_estimate(best))
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
        metrics=board_metrics.values(run.benchmark, result.metrics),
    )


def _rows(benchmark: str) -> Select[*tuple[Any, ...]]:
    return (
        select(*_COLUMNS, Best.standard_error, Best.degrees)
        .join(Run, Run.id == Best.run_id)
        .join(User, User.id == Best.user_id)
        .where(Best.benchmark == benchmark)
    )


def _keys(benchmark: str) -> Select[*tuple[Any, ...]]:
    columns = (Best.user_id, Best.run_id, Best.is_baseline, Best.score, Best.reached_at)
    query = select(*columns, Best.language, Best.vehicle, Best.tracker, Best.metrics)
    return query.where(Best.benchmark == benchmark)


def _leading(benchmark: Benchmark, count: int) -> Select[*tuple[Any, ...]]:
    """Select so many first rows that `count` people are among them, if there are as many."""
    return _rows(benchmark.name).order_by(*_ORDER).limit(count + len(benchmark.baselines))


def _leaders(rows: Iterable[Row[*tuple[Any, ...]]], count: int) -> list[Rank]:
    people = islice((row for row in rows if not row.is_baseline), count)
    return [_rank(row, number, None) for number, row in enumerate(people, start=1)]


def _order(row: Row[*tuple[Any, ...]]) -> tuple[float, float, int]:
    return place(Cursor(row.score, row.reached_at, row.run_id))


def place(cursor: Cursor) -> tuple[float, float, int]:
    """Return what sorts as `_ORDER` does."""
    return -cursor.score, cursor.reached_at, cursor.run_id


def _below(cursor: Cursor) -> tuple[ColumnElement[bool], ...]:
    # The first condition says less than the second, but databases find it in the index.
    return Best.score <= cursor.score, ~_not_below(cursor)


def _not_below(cursor: Cursor) -> ColumnElement[bool]:
    same = Best.score == cursor.score
    return or_(
        Best.score > cursor.score,
        and_(same, Best.reached_at < cursor.reached_at),
        and_(same, Best.reached_at == cursor.reached_at, Best.run_id <= cursor.run_id),
    )


def people_down_to(session: Session, benchmark: str, here: Cursor) -> int:
    """Return the number of people at or above a row."""
    not_below = _not_below(here)
    return score_counts.at_or_above(session, benchmark, here.score, not_below=not_below)


def _estimate(best: Best | Row[*tuple[Any, ...]]) -> Estimate:
    return Estimate(score=best.score, standard_error=best.standard_error, degrees=best.degrees)


def _rank(row: Row[*tuple[Any, ...]], number: int, people: Population | None) -> Rank:
    low, high = None, None
    if people is not None and not row.is_baseline:
        low, high = people.rank_range(_estimate(row))
    values = row._asdict() | {"metrics": row.metrics or {}}
    if row.anonymous:
        masked = {"user": anonymity.NAME, "affiliation": ""}
        values |= masked | {"program_name": anonymity.file_name(row.program_name)}
    del values["standard_error"], values["degrees"]
    rank = None if row.is_baseline else number
    return Rank(rank=rank, rank_low=low, rank_high=high, **values)
