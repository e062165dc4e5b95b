"""The board of a round as its page shows it: a part of the rows, with the marks between them."""

from collections.abc import Sequence
from dataclasses import dataclass

from seamark.server.judging.boards import Board, BoardRow
from seamark.server.pages.charts import plots
from seamark.server.pages.charts.plots import Axis

SIZE = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownRow:
    """A row with a score."""

    row: BoardRow
    score: float
    low: float  # the score itself if its interval is unknown
    high: float
    is_own: bool = False
    is_oracle: bool = False

    @property
    def is_baseline(self) -> bool:
        """Whether it is a reference entry, a mark without a place."""
        return self.row.team_id is None

    @property
    def title(self) -> str:
        """What a mark is called."""
        return self.row.method


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownBoard:
    """The rows of a page of a board, and what its plots need."""

    rows: Sequence[ShownRow]
    failed: Sequence[BoardRow]
    marks: Sequence[ShownRow]
    own: Sequence[BoardRow]
    axis: Axis
    count: int  # of the teams or methods with a place
    by_method: bool
    first: int  # number of the first row of the page, from 0
    next: int | None  # number of the first row of the next page


def shown_board(board: Board, team_id: int | None, first: int) -> ShownBoard:
    """Return the part of a board that begins with a row; that of a team is marked."""
    scored = [row for row in board.rows if row.score is not None]
    placed = [_shown(row, team_id) for row in scored]
    marks = [_shown(row, None) for row in board.references if row.score is not None]
    # A failed finalist has no score, and comes after all that have one.
    together = sorted([*placed, *marks], key=lambda one: -one.score)
    rows = together[first : first + SIZE]
    return ShownBoard(
        rows=rows,
        failed=[row for row in board.rows if row.score is None],
        marks=marks,
        own=[] if team_id is None else board.of_team(team_id),
        axis=plots.score_axis(rows, marks, whole=False),
        count=len(scored),
        by_method=board.by_method,
        first=first,
        next=first + SIZE if first + SIZE < len(together) else None,
    )


def _shown(row: BoardRow, team_id: int | None) -> ShownRow:
    score = row.score or 0.0
    return ShownRow(
        row=row,
        score=score,
        low=score if row.low is None else row.low,
        high=score if row.high is None else row.high,
        is_own=team_id is not None and row.team_id == team_id,
    )
