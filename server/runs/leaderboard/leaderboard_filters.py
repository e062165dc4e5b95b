"""A leaderboard with filters, or in the order of another metric: at the cost of a bounded look.

Neither has an index of its own. A filtered page looks at no more than `SEEN_MAX` rows and so may be
short and yet have a next one; another order is that of the first `SORTED_MAX` rows by score.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

from sqlalchemy.orm import Session

from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.leaderboard.leaderboard import Cursor, Kind, Rank
from seamark.server.runs.leaderboard.ranking import Population
from seamark.sim.metrics.metric import Metric

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

    vehicle: str = ""
    tracker: str = ""  # built in
    language: str = ""  # of uploaded programs
    program: str = ""  # UPLOADED or BUILT_IN
    baselines: str = ""  # HIDE or ONLY
    user_id: int | None = None  # the row of this user alone

    @property
    def active(self) -> bool:
        """Whether it leaves anything out."""
        return self != BoardFilter()

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
    people: Population | None = None,
) -> BoardPage:
    """Return the next rows that pass a filter, best first; their ranks are among all people.

    `people` are those of the leaderboard, if the caller has them.
    """
    if not board_filter.active:
        ranks = leaderboard.page(session, benchmark, after=after, limit=limit + 1, people=people)
        more = len(ranks) > limit
        return BoardPage(ranks[:limit], ranks[limit - 1].cursor if more else None)
    if board_filter.user_id is not None:
        own = leaderboard.rank_of(session, benchmark, board_filter.user_id, people)
        return BoardPage([own] if own and after is None and board_filter.passes(own) else [], None)
    if board_filter.baselines == ONLY:
        seen = leaderboard.baseline_keys(session, benchmark, after=after)
    else:
        seen = leaderboard.keys(session, benchmark, after=after, limit=SEEN_MAX)
    shown = [key for key in seen if board_filter.passes(key)]
    following = seen[-1].cursor if len(seen) == SEEN_MAX else None
    if len(shown) > limit:
        shown, following = shown[:limit], shown[limit - 1].cursor
    return BoardPage(leaderboard.rows_of(session, benchmark, shown, people), following)


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
    people: Population | None = None,
) -> list[Rank]:
    """Return the best rows by another metric, of the first `SORTED_MAX` by score.

    Rows without the metric are left out; their ranks are those by score.
    """
    seen = leaderboard.keys(session, benchmark, limit=SORTED_MAX)
    measured = [key for key in seen if metric.name in key.metrics and board_filter.passes(key)]
    measured.sort(key=lambda key: _cost(metric, key.metrics))
    return leaderboard.rows_of(session, benchmark, measured[:limit], people)


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
