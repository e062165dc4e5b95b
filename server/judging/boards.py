"""Boards of rounds: the best entry of each team or of each method, with ranges of ranks."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from seamark.server.competitions import teams
from seamark.server.competitions.competitions import CHECK, CompetitionView, RoundView
from seamark.server.database.competition_tables import Entry, FinalPlace, Round
from seamark.sim.numerics.ranking import Estimate, rank_ranges

ROWS_MAX = 5000


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardRow:
    """A row of a board."""

    place: int | None  # None: a reference entry, or it failed
    place_low: int | None
    place_high: int | None
    team_id: int | None
    team: str  # empty: a reference entry
    method: str
    run_id: int
    score: float | None
    low: float | None
    high: float | None
    submitted_at: float
    submissions: int = 1  # with a score
    refusal: str | None = None
    standard_error: float | None = None
    degrees: int = 0


@dataclass(frozen=True, slots=True)
class Board:
    """The rows of a round, the best first, and the marks that the service set."""

    rows: tuple[BoardRow, ...]
    references: tuple[BoardRow, ...]
    by_method: bool

    def per_team(self) -> "Board":
        """Return the board with the best row of each team alone; places stay as they are."""
        return Board(_first_of_teams(self.rows), self.references, by_method=False)

    def of_team(self, team_id: int) -> list[BoardRow]:
        """Return the rows of a team."""
        return [row for row in self.rows if row.team_id == team_id]


def board(
    session: Session, competition: CompetitionView, one: RoundView, *, by_method: bool = False
) -> Board:
    """Return the board of a round: of decided ones that decide the competition, the final places.

    A team has one row, its best one, unless rows are by method.
    """
    if one.id == competition.deciding.id and one.decided_at is not None:
        decided = Board(*_final(session, competition, one), by_method=True)
        return decided if by_method else decided.per_team()
    rows = _best(session, competition, one, by_method=by_method)
    return Board(_ranked(rows), tuple(_references(session, competition)), by_method)


def _best(
    session: Session, competition: CompetitionView, one: RoundView, *, by_method: bool
) -> list[BoardRow]:
    """Return the best entry of each team or method, the best first; equal ones by time."""
    of = (Entry.team_id, Entry.method_key) if by_method else (Entry.team_id,)
    order = (Entry.score.desc(), Entry.submitted_at, Entry.run_id)
    counted = (
        select(
            *(Entry.run_id, Entry.team_id, Entry.method, Entry.score, Entry.submitted_at),
            *(Entry.score_low, Entry.score_high, Entry.standard_error, Entry.degrees),
            func.row_number().over(partition_by=of, order_by=order).label("number"),
            func.count().over(partition_by=of).label("submissions"),
        )
        .where(Entry.round_id == one.id, Entry.team_id.is_not(None))
        .where(Entry.score.is_not(None), Entry.withdrawn_at.is_(None))
        .subquery()
    )
    best = select(counted).where(counted.c.number == 1)
    best = best.order_by(counted.c.score.desc(), counted.c.submitted_at, counted.c.run_id)
    names = teams.names(session, competition.id)
    return [
        BoardRow(
            place=None,
            place_low=None,
            place_high=None,
            team_id=row.team_id,
            team=names.get(row.team_id, ""),
            method=row.method,
            run_id=row.run_id,
            score=row.score,
            low=row.score_low,
            high=row.score_high,
            submitted_at=row.submitted_at,
            submissions=row.submissions,
            standard_error=row.standard_error,
            degrees=row.degrees,
        )
        for row in session.execute(best.limit(ROWS_MAX))
    ]


def _ranked(rows: Sequence[BoardRow]) -> tuple[BoardRow, ...]:
    """Return rows with their places: each had water of its own, so they are independent."""
    estimates = [
        Estimate(score=row.score or 0.0, standard_error=row.standard_error, degrees=row.degrees)
        for row in rows
    ]
    return tuple(
        replace(row, place=place, place_low=low, place_high=high)
        for place, (row, (low, high)) in enumerate(
            zip(rows, rank_ranges(estimates), strict=True), 1
        )
    )


def _references(session: Session, competition: CompetitionView) -> list[BoardRow]:
    """Return the reference entries as the check evaluated them, the best first."""
    query = (
        select(Entry)
        .join(Round, Round.id == Entry.round_id)
        .where(Round.competition_id == competition.id, Round.number == CHECK)
        .where(Entry.score.is_not(None))
        .order_by(Entry.score.desc())
    )
    return [
        BoardRow(
            place=None,
            place_low=None,
            place_high=None,
            team_id=None,
            team="",
            method=row.method,
            run_id=row.run_id,
            score=row.score,
            low=row.score_low,
            high=row.score_high,
            submitted_at=row.submitted_at,
        )
        for row in session.scalars(query)
    ]


def _final(
    session: Session, competition: CompetitionView, one: RoundView
) -> tuple[tuple[BoardRow, ...], tuple[BoardRow, ...]]:
    """Return the places of a decided competition, and its reference entries."""
    query = (
        select(FinalPlace, Entry.submitted_at)
        .join(Entry, Entry.run_id == FinalPlace.run_id)
        .where(FinalPlace.round_id == one.id)
        .order_by(FinalPlace.score.is_(None), FinalPlace.score.desc(), Entry.submitted_at)
    )
    names = teams.names(session, competition.id)
    rows = [
        BoardRow(
            place=row.place,
            place_low=row.place_low,
            place_high=row.place_high,
            team_id=row.team_id,
            team="" if row.team_id is None else names.get(row.team_id, ""),
            method=row.method,
            run_id=row.run_id,
            score=row.score,
            low=row.score_low,
            high=row.score_high,
            submitted_at=submitted_at,
            refusal=row.refusal,
        )
        for row, submitted_at in session.execute(query)
    ]
    placed = tuple(row for row in rows if row.team_id is not None)
    return placed, tuple(row for row in rows if row.team_id is None)


def _first_of_teams(rows: Sequence[BoardRow]) -> tuple[BoardRow, ...]:
    """Return the best row of each team; places stay those among all methods."""
    seen = set[int | None]()
    first = []
    for row in rows:
        if row.team_id not in seen:
            seen.add(row.team_id)
            first.append(row)
    return tuple(first)
