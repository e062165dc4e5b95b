"""What a row of a leaderboard is: its columns, for queries, the API and the CSV, and its place."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Self, get_type_hints

from seamark.server.database.tables import Best, Run, User
from seamark.server.runs.record import solutions


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """What the database and the API have of a field of a `Rank`, and of it alone."""

    name: str  # of the field
    type: Any
    selected: Any = None  # None: it is computed; of `Best`, or of `per.table` in its place
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
    submissions: int | None = field(
        metadata=_of(
            Best.submissions,
            meaning="ranked runs of this user in this benchmark that ended; null for an anonymous "
            "method, which it would link to others of its author",
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
