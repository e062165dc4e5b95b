"""A leaderboard with filters, or in the order of another metric: at the cost of a bounded look.

Neither has an index of its own. A filtered page looks at no more than `SEEN_MAX` rows and so may be
short and yet have a next one; another order is that of the first `SORTED_MAX` rows by score.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

from sqlalchemy.orm import Session

from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.leaderboard.board_rows import Cursor, Rank
from seamark.server.runs.leaderboard.leaderboard import Key, Kind
from seamark.server.runs.leaderboard.per import Per
from seamark.sim.metrics.metric import Metric
from seamark.sim.numerics.ranking import Population

SEEN_MAX = 1000  # rows that a filtered page looks at
SORTED_MAX = 500  # rows by score that are sorted by another metric
UPLOADED, BUILT_IN = "uploaded", "built-in"  # kinds of programs
HIDE, ONLY = "hide", "only"  # baselines


class Filtered(Protocol):
    """What a filter looks at; keys and whole rows have it."""

    @property
    def user_id(self) -> int: ...  # noqa: D102 - the attribute of tables.Best
    @property
    def is_baseline(self) -> bool: ...  # noqa: D102
    @property
    def language(self) -> str: ...  # noqa: D102
    @property
    def vehicle(self) -> str: ...  # noqa: D102
    @property
    def tracker(self) -> str: ...  # noqa: D102


class Measured(Protocol):
    """An entry with metrics: a row, or a reference entry."""

    @property
    def metrics(self) -> Mapping[str, float]:
        """Name -> value; of `Benchmark.board_metrics`."""


Entry = TypeVar("Entry", bound=Measured)


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardFilter:
    """Which rows of a leaderboard are shown; empty values show all."""

    per: Per = Per.PERSON
    vehicle: str = ""
    tracker: str = ""  # built in
    language: str = ""  # of uploaded programs
    program: str = ""  # UPLOADED or BUILT_IN
    baselines: str = ""  # HIDE or ONLY
    user_id: int | None = None  # the rows of this user alone

    @property
    def active(self) -> bool:
        """Whether it leaves out any of the rows."""
        return self != BoardFilter(per=self.per)

    def passes(self, row: Filtered) -> bool:
        """Return whether a row is shown."""
        kind = UPLOADED if row.language else BUILT_IN
        return (
            self.vehicle in ("", row.vehicle)
            and self.tracker in ("", row.tracker)
            and self.language in ("", row.language)
            and self.program in ("", kind)
            and self.baselines in ("", ONLY if row.is_baseline else HIDE)
            and self.user_id in (None, row.user_id)
        )


@dataclass(frozen=True, slots=True)
class BoardPage:
    """Some rows of a leaderboard, and where the next page begins; None at the end."""

    ranks: list[Rank]
    next: Cursor | None


def page(
    session: Session,
    benchmark: str,
    board_filter: BoardFilter,
    *,
    after: Cursor | None = None,
    limit: int = 50,
    population: Population | None = None,
) -> BoardPage:
    """Return the next rows that pass a filter, best first; their ranks are among all rows.

    `population` is that of the rows, if the caller has it.
    """
    per, user_id = board_filter.per, board_filter.user_id
    asked = limit + 1  # one more, to know whether there is a next page
    if user_id is not None:
        ranks = leaderboard.ranks_of(
            *(session, benchmark, user_id),
            per=per,
            after=after,
            limit=asked,
            population=population,
        )
    elif board_filter.active:
        keys, following = _passing(session, benchmark, board_filter, after=after, limit=limit)
        rows = leaderboard.rows_of(session, benchmark, keys, per=per, population=population)
        return BoardPage(rows, following)
    else:
        ranks = leaderboard.page(
            session, benchmark, per=per, after=after, limit=asked, population=population
        )
    shown = [rank for rank in ranks[:limit] if board_filter.passes(rank)]
    return BoardPage(shown, ranks[limit - 1].cursor if len(ranks) > limit else None)


def _passing(
    session: Session,
    benchmark: str,
    board_filter: BoardFilter,
    *,
    after: Cursor | None,
    limit: int,
) -> tuple[list[Key], Cursor | None]:
    """Return the keys of the next rows that pass, of those looked at, and where to go on."""
    per = board_filter.per
    if board_filter.baselines == ONLY:
        seen = leaderboard.baseline_keys(session, benchmark, per=per, after=after)
    else:
        seen = leaderboard.keys(session, benchmark, per=per, after=after, limit=SEEN_MAX)
    passing = [key for key in seen if board_filter.passes(key)]
    if len(passing) > limit:
        return passing[:limit], passing[limit - 1].cursor
    return passing, seen[-1].cursor if len(seen) == SEEN_MAX else None


def choices(kinds: Iterable[Kind]) -> dict[str, list[str]]:
    """Return filter -> the values of which at least one row passes and one does not."""
    rows = list(kinds)
    values: dict[str, set[str]] = {
        "program": {UPLOADED if row.language else BUILT_IN for row in rows},
        "language": {row.language for row in rows if row.language},
        "vehicle": {row.vehicle for row in rows},
        "tracker": {row.tracker for row in rows},
        "baselines": {ONLY if row.is_baseline else HIDE for row in rows},
    }
    return {name: sorted(options - {""}) for name, options in values.items() if len(options) > 1}


def by_metric(
    session: Session,
    benchmark: str,
    metric: Metric,
    board_filter: BoardFilter,
    *,
    limit: int = 50,
    population: Population | None = None,
) -> list[Rank]:
    """Return the best rows by another metric, of the first `SORTED_MAX` by score.

    Rows without the metric are left out; their ranks are those by score.
    """
    per = board_filter.per
    seen = leaderboard.keys(session, benchmark, per=per, limit=SORTED_MAX)
    measured = [key for key in seen if metric.name in key.metrics and board_filter.passes(key)]
    measured.sort(key=lambda key: _cost(metric, key.metrics))
    return leaderboard.rows_of(session, benchmark, measured[:limit], per=per, population=population)


def undominated(ranks: Sequence[Entry], first: Metric, second: Metric) -> list[Entry]:
    """Return the Pareto front: the rows that no other one beats in both metrics.

    They are sorted by the first metric, best first; rows without one of them are left out.
    """

    def key(rank: Entry) -> tuple[float, float]:
        return _cost(first, rank.metrics), _cost(second, rank.metrics)

    measured = [r for r in ranks if first.name in r.metrics and second.name in r.metrics]
    front: list[Entry] = []
    for rank in sorted(measured, key=key):
        if not front or key(rank)[1] < key(front[-1])[1]:
            front.append(rank)
    return front


def _cost(metric: Metric, values: Mapping[str, float]) -> float:
    """Return the value of a metric with such a sign that less is better."""
    return values[metric.name] * (-1.0 if metric.better == "higher" else 1.0)
