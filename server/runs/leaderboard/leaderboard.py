"""The leaderboard: `best` rows are kept up to date, so a page costs the same at any depth.

A user has one row per benchmark, the best published ranked run, or one per method: `Per` says which
rows they are. Without it a function is about people.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, NamedTuple, Self

from sqlalchemy import ColumnElement, Row, Select, and_, or_, select, union_all
from sqlalchemy.orm import Session

from seamark.server.database.tables import Best, BoardRow, Run, User, is_baseline
from seamark.server.runs.leaderboard import score_counts
from seamark.server.runs.leaderboard.board_rows import COLUMNS, Cursor, Rank
from seamark.server.runs.leaderboard.per import Per
from seamark.server.runs.record import anonymity
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.numerics.ranking import Estimate, Population


def _selected(per: Per) -> Iterator[ColumnElement[Any]]:
    """Yield what a row consists of. Columns alone: objects of the ORM take longer."""
    for one in COLUMNS:
        if one.selected is not None:
            of_row = one.selected.class_ is Best
            column = getattr(per.table, one.selected.key) if of_row else one.selected
            yield column.label(one.name)


_SELECTED = {per: tuple(_selected(per)) for per in Per}


def page(
    session: Session,
    benchmark: str,
    *,
    per: Per = Per.PERSON,
    after: Cursor | None = None,
    limit: int = 50,
    population: Population | None = None,
) -> list[Rank]:
    """Return the next rows of one benchmark, best first; equal scores in order of time.

    `population` is that of the rows, if the caller has it; here and below.
    """
    query = _rows(benchmark, per).order_by(*_order(per)).limit(limit)
    number = 0
    if after is not None:
        query = query.where(*_below(after, per))
        number = count_down_to(session, benchmark, after, per)
    population = population or score_counts.population(session, benchmark, per)
    ranks: list[Rank] = []
    for row in session.execute(query):
        number += not row.is_baseline
        ranks.append(_rank(row, number, population, per))
    return ranks


def leaders(session: Session, benchmark: Benchmark, count: int) -> list[Rank]:
    """Return the first rows of a leaderboard, without baselines and without ranges of ranks."""
    return _leaders(session.execute(_leading(benchmark, count)), count)


def leaders_of(
    session: Session, benchmarks: Sequence[Benchmark], count: int
) -> dict[str, list[Rank]]:
    """Return name -> `leaders` of some benchmarks, by one statement."""
    each = (select(_leading(benchmark, count).subquery()) for benchmark in benchmarks)
    rows = sorted(session.execute(union_all(*each)), key=_place_of)
    return {
        benchmark.name: _leaders((row for row in rows if row.benchmark == benchmark.name), count)
        for benchmark in benchmarks
    }


class Kind(NamedTuple):
    """What filters tell rows apart by."""

    language: str  # empty: a built-in solution
    vehicle: str
    tracker: str  # empty: the program's own
    is_baseline: bool


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


def keys(
    session: Session,
    benchmark: str,
    *,
    per: Per = Per.PERSON,
    after: Cursor | None = None,
    limit: int,
) -> list[Key]:
    """Return the keys of the next rows, best first: a fraction of the work of whole rows."""
    query = _keys(benchmark, per).order_by(*_order(per)).limit(limit)
    number = 0
    if after is not None:
        query = query.where(*_below(after, per))
        number = count_down_to(session, benchmark, after, per)
    merged: list[Key] = []
    for row in session.execute(query):
        number += not row.is_baseline
        merged.append(Key.of(number, row))
    return merged


def baseline_keys(
    session: Session, benchmark: str, *, per: Per = Per.PERSON, after: Cursor | None = None
) -> list[Key]:
    """Return the keys of all baselines, or of those after a row, best first. They are few.

    Sorted here: with ORDER BY, SQLite would look for them among all rows in that order.
    """
    rows = session.execute(_keys(benchmark, per).where(is_baseline(per.table)))
    ordered = [Key.of(0, row) for row in rows]
    ordered.sort(key=lambda key: place(key.cursor))
    return [key for key in ordered if after is None or place(key.cursor) > place(after)]


def kinds(session: Session, benchmark: str, *, per: Per = Per.PERSON, limit: int) -> set[Kind]:
    """Return what filters can tell apart among the first rows."""
    row = per.table
    query = select(row.language, row.vehicle, row.tracker, row.is_baseline)
    first = query.where(row.benchmark == benchmark).order_by(*_order(per)).limit(limit)
    return {Kind(*each) for each in session.execute(select(first.subquery()).distinct())}


def rows_of(
    session: Session,
    benchmark: str,
    chosen: Sequence[Key],
    *,
    per: Per = Per.PERSON,
    population: Population | None = None,
) -> list[Rank]:
    """Return the whole rows of some keys, in their order."""
    if not chosen:
        return []
    query = _rows(benchmark, per).where(per.table.run_id.in_([key.run_id for key in chosen]))
    rows = {row.run_id: row for row in session.execute(query)}
    population = population or score_counts.population(session, benchmark, per)
    return [
        _rank(rows[key.run_id], key.number, population, per) for key in chosen if key.run_id in rows
    ]


def ranks_of(
    session: Session,
    benchmark: str,
    user_id: int,
    *,
    per: Per = Per.PERSON,
    after: Cursor | None = None,
    limit: int = 1,
    population: Population | None = None,
) -> list[Rank]:
    """Return the next of a user's own rows, best first. They are sorted here, as baselines are."""
    rows = session.execute(_rows(benchmark, per).where(per.table.user_id == user_id))
    ordered = sorted(rows, key=_place_of)
    following = [row for row in ordered if after is None or _place_of(row) > place(after)][:limit]
    if not following:
        return []
    population = population or score_counts.population(session, benchmark, per)
    return [
        _rank(row, count_down_to(session, benchmark, _cursor(row), per), population, per)
        for row in following
    ]


def rank_of(
    session: Session,
    benchmark: str,
    user_id: int,
    *,
    per: Per = Per.PERSON,
    population: Population | None = None,
) -> Rank | None:
    """Return the best of a user's own rows, or None without one."""
    own = ranks_of(session, benchmark, user_id, per=per, population=population)
    return own[0] if own else None


def _rows(benchmark: str, per: Per = Per.PERSON) -> Select[*tuple[Any, ...]]:
    own = per.table
    return (
        select(*_SELECTED[per], own.standard_error, own.degrees)
        .join(Run, Run.id == own.run_id)
        .join(User, User.id == own.user_id)
        .where(own.benchmark == benchmark)
    )


def _keys(benchmark: str, per: Per) -> Select[*tuple[Any, ...]]:
    own = per.table
    columns = (own.user_id, own.run_id, own.is_baseline, own.score, own.reached_at)
    query = select(*columns, own.language, own.vehicle, own.tracker, own.metrics)
    return query.where(own.benchmark == benchmark)


def _order(per: Per) -> tuple[ColumnElement[Any], ...]:
    own = per.table
    return own.score.desc(), own.reached_at.asc(), own.run_id.asc()


def _leading(benchmark: Benchmark, count: int) -> Select[*tuple[Any, ...]]:
    """Select so many first rows that `count` people are among them, if there are as many."""
    return (
        _rows(benchmark.name).order_by(*_order(Per.PERSON)).limit(count + len(benchmark.baselines))
    )


def _leaders(rows: Iterable[Row[*tuple[Any, ...]]], count: int) -> list[Rank]:
    people = islice((row for row in rows if not row.is_baseline), count)
    return [_rank(row, number, None) for number, row in enumerate(people, start=1)]


def _cursor(row: Row[*tuple[Any, ...]]) -> Cursor:
    return Cursor(row.score, row.reached_at, row.run_id)


def _place_of(row: Row[*tuple[Any, ...]]) -> tuple[float, float, int]:
    return place(_cursor(row))


def place(cursor: Cursor) -> tuple[float, float, int]:
    """Return what sorts as `_order` does."""
    return -cursor.score, cursor.reached_at, cursor.run_id


def _below(cursor: Cursor, per: Per) -> tuple[ColumnElement[bool], ...]:
    # The first condition says less than the second, but databases find it in the index.
    return per.table.score <= cursor.score, ~_not_below(cursor, per)


def _not_below(cursor: Cursor, per: Per) -> ColumnElement[bool]:
    own = per.table
    same = own.score == cursor.score
    return or_(
        own.score > cursor.score,
        and_(same, own.reached_at < cursor.reached_at),
        and_(same, own.reached_at == cursor.reached_at, own.run_id <= cursor.run_id),
    )


def count_down_to(session: Session, benchmark: str, here: Cursor, per: Per = Per.PERSON) -> int:
    """Return the number of people or methods at or above a row."""
    not_below = _not_below(here, per)
    return score_counts.at_or_above(session, benchmark, here.score, not_below=not_below, per=per)


def estimate_of(row: BoardRow | Row[*tuple[Any, ...]]) -> Estimate:
    """Return the score of a row with what is known of its uncertainty."""
    return Estimate(score=row.score, standard_error=row.standard_error, degrees=row.degrees)


def _rank(
    row: Row[*tuple[Any, ...]],
    number: int,
    population: Population | None,
    per: Per = Per.PERSON,
) -> Rank:
    low, high = None, None
    if population is not None and not row.is_baseline:
        low, high = population.rank_range(estimate_of(row))
    values = row._asdict() | {"metrics": row.metrics or {}}
    if row.anonymous:
        masked = {"user": anonymity.NAME, "affiliation": ""}
        values |= masked | {"program_name": anonymity.file_name(row.program_name)}
        if per is Per.METHOD:  # all methods of an author have the same number
            values["submissions"] = None
    del values["standard_error"], values["degrees"]
    rank = None if row.is_baseline else number
    return Rank(rank=rank, rank_low=low, rank_high=high, **values)
