"""The leaderboard: `best` rows are kept up to date, so a page costs the same at any depth.

A user has one row per benchmark: the best published ranked run.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from itertools import islice
from typing import Any, NamedTuple, Self, get_type_hints

from sqlalchemy import (
    ColumnElement,
    Row,
    Select,
    and_,
    or_,
    select,
    union_all,
)
from sqlalchemy.orm import Session

from seamark.server.database.tables import IS_BASELINE, Best, Run, User
from seamark.server.runs.leaderboard import score_counts
from seamark.server.runs.leaderboard.ranking import Estimate, Population
from seamark.server.runs.record import anonymity, solutions
from seamark.sim.benchmarks.benchmark import Benchmark


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """What the database and the API have of a field of a `Rank`, and of it alone."""

    name: str  # of the field
    type: Any
    selected: Any = None  # None: it is computed
    answered: str = ""  # its name at the API and in the CSV; empty: it is not there
    meaning: str | None = None  # in the documentation of the API
    answer: "Callable[[Rank], Any] | None" = None  # what the API says; None: the field itself
    after: str = ""  # the column of the CSV before it; empty: the one before it here

    def value(self, rank: "Rank") -> Any:
        """Return what the API answers of a row."""
        return getattr(rank, self.name) if self.answer is None else self.answer(rank)


def _of(selected: Any = None, **more: Any) -> dict[str, Any]:
    """Return the metadata of a field: keywords of a `Column`, with its own name at the API."""
    return {"column": {"selected": selected, **more}}


def _program(rank: "Rank") -> str:
    return rank.program_name or rank.controller


@dataclass(frozen=True, slots=True, kw_only=True)
class Rank:
    """One row of the leaderboard. A column is declared here alone: for queries, API and CSV.

    A baseline has no rank: it is a mark on the scale, and moves nobody down.
    """

    rank: int | None = field(  # by the score; equal scores in order of time
        metadata=_of(meaning="null for reference entries, which are marks without a rank")
    )
    rank_low: int | None = field(  # see `ranking`
        metadata=_of(meaning="best rank that is compatible with all scores (95 %)")
    )
    rank_high: int | None = field(
        metadata=_of(meaning="worst rank that is compatible with all scores")
    )
    user: str = field(metadata=_of(User.name))  # no name if `anonymous`
    method: str = field(
        metadata=_of(Run.method, meaning="what the entry is called", answer=solutions.entry_name)
    )
    controller: str = field(
        metadata=_of(
            Run.controller,
            meaning="name of the program's file, or of the built-in solution",
            answer=_program,
        )
    )
    run_id: int = field(metadata=_of(Best.run_id, answered="run"))
    score: float = field(metadata=_of(Best.score))
    low: float = field(metadata=_of(Best.score_low, answered="score_low"))
    high: float = field(metadata=_of(Best.score_high, answered="score_high"))
    level_held: float | None = field(metadata=_of(Best.level_held))
    submissions: int = field(
        metadata=_of(
            Best.submissions, meaning="ranked runs of this user in this benchmark that ended"
        )
    )
    reached_at: float = field(metadata=_of(Best.reached_at))
    is_baseline: bool = field(metadata=_of(Best.is_baseline))
    title: str = field(metadata=_of(Run.title, meaning="of the run"))
    notes: str = field(
        metadata=_of(
            Run.notes, meaning="of the run: how its author describes the method", after="tracker"
        )
    )
    affiliation: str = field(metadata=_of(User.affiliation, meaning="of the user", after="user"))
    language: str = field(
        metadata=_of(
            Best.language, meaning="of the uploaded program; empty for a built-in solution"
        )
    )
    vehicle: str = field(metadata=_of(Best.vehicle))
    tracker: str = field(
        metadata=_of(Best.tracker, meaning="built-in tracker; empty if the program is the tracker")
    )
    metrics: Mapping[str, float] = field(  # `Benchmark.board_metrics`
        metadata=_of(Best.metrics, meaning="by name, such as the benchmark lists them")
    )
    anonymous: bool = field(
        metadata=_of(Run.anonymous, meaning="published for review: `user` is no name")
    )
    user_id: int = field(metadata=_of(Best.user_id, answered=""))
    benchmark: str = field(metadata=_of(Run.benchmark, answered=""))
    config: dict[str, Any] = field(metadata=_of(Run.config, answered=""))
    program_name: str | None = field(metadata=_of(Run.program_name, answered=""))

    @property
    def cursor(self) -> Cursor:
        """Where to go on after this row."""
        return Cursor(self.score, self.reached_at, self.run_id)


_TYPES = get_type_hints(Rank)
COLUMNS = [
    Column(name=one.name, type=_TYPES[one.name], **{"answered": one.name} | one.metadata["column"])
    for one in fields(Rank)
]
# Columns alone: objects of the ORM take longer.
_SELECTED = [one.selected.label(one.name) for one in COLUMNS if one.selected is not None]


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


def keys(session: Session, benchmark: str, *, after: Cursor | None = None, limit: int) -> list[Key]:
    """Return the keys of the next rows, best first: a fraction of the work of whole rows."""
    query = _keys(benchmark).order_by(*_ORDER).limit(limit)
    number = 0
    if after is not None:
        query = query.where(*_below(after))
        number = people_down_to(session, benchmark, after)
    merged: list[Key] = []
    for row in session.execute(query):
        number += not row.is_baseline
        merged.append(Key.of(number, row))
    return merged


def baseline_keys(session: Session, benchmark: str, *, after: Cursor | None = None) -> list[Key]:
    """Return the keys of all baselines, or of those after a row, best first. They are few.

    Sorted here: with ORDER BY, SQLite would look for them among all rows in that order.
    """
    rows = session.execute(_keys(benchmark).where(IS_BASELINE))
    ordered = [Key.of(0, row) for row in rows]
    ordered.sort(key=lambda key: place(key.cursor))
    return [key for key in ordered if after is None or place(key.cursor) > place(after)]


def kinds(session: Session, benchmark: str, *, limit: int) -> set[Kind]:
    """Return what filters can tell apart among the first rows."""
    columns = (Best.language, Best.vehicle, Best.tracker, Best.is_baseline)
    first = select(*columns).where(Best.benchmark == benchmark).order_by(*_ORDER).limit(limit)
    return {Kind(*row) for row in session.execute(select(first.subquery()).distinct())}


def rows_of(
    session: Session, benchmark: str, chosen: Sequence[Key], people: Population | None = None
) -> list[Rank]:
    """Return the whole rows of some keys, in their order."""
    if not chosen:
        return []
    query = _rows(benchmark).where(Best.user_id.in_([key.user_id for key in chosen]))
    rows = {row.user_id: row for row in session.execute(query)}
    people = score_counts.population(session, benchmark) if people is None else people
    return [_rank(rows[key.user_id], key.number, people) for key in chosen if key.user_id in rows]


def rank_of(
    session: Session, benchmark: str, user_id: int, people: Population | None = None
) -> Rank | None:
    """Return a user's own row, or None without one."""
    row = session.execute(_rows(benchmark).where(Best.user_id == user_id)).one_or_none()
    if row is None:
        return None
    here = Cursor(row.score, row.reached_at, row.run_id)
    number = people_down_to(session, benchmark, here)
    people = score_counts.population(session, benchmark) if people is None else people
    return _rank(row, number, people)


def _rows(benchmark: str) -> Select[*tuple[Any, ...]]:
    return (
        select(*_SELECTED, Best.standard_error, Best.degrees)
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


def estimate_of(best: Best | Row[*tuple[Any, ...]]) -> Estimate:
    """Return the score of a row with what is known of its uncertainty."""
    return Estimate(score=best.score, standard_error=best.standard_error, degrees=best.degrees)


def _rank(row: Row[*tuple[Any, ...]], number: int, people: Population | None) -> Rank:
    low, high = None, None
    if people is not None and not row.is_baseline:
        low, high = people.rank_range(estimate_of(row))
    values = row._asdict() | {"metrics": row.metrics or {}}
    if row.anonymous:
        masked = {"user": anonymity.NAME, "affiliation": ""}
        values |= masked | {"program_name": anonymity.file_name(row.program_name)}
    del values["standard_error"], values["degrees"]
    rank = None if row.is_baseline else number
    return Rank(rank=rank, rank_low=low, rank_high=high, **values)
