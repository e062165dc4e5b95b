"""The history of ranks: a point whenever the row of a user changes.

A rank also changes because others publish. To store that for everybody would cost as many rows as
there are people for each publication, so those changes are seen at the next point of the user, and
in the present rank.
"""

import time
from collections.abc import Sequence

from sqlalchemy import ColumnElement, delete, select
from sqlalchemy.orm import Session

from seamark.server.database.publication_tables import RankPoint
from seamark.server.runs.leaderboard import score_counts

KEPT = 200  # points of a user in a benchmark; older ones are deleted


def of_user(session: Session, user_id: int, benchmark: str) -> Sequence[RankPoint]:
    """Return the points of a user in a benchmark, oldest first."""
    query = select(RankPoint).where(*_whose(user_id, benchmark)).order_by(RankPoint.id.desc())
    return list(reversed(session.scalars(query.limit(KEPT)).all()))


def record(
    session: Session, user_id: int, benchmark: str, *, rank: int | None, score: float | None
) -> None:
    """Store the present rank of a user unless it is that of the last point."""
    whose = _whose(user_id, benchmark)
    newest = select(RankPoint).where(*whose).order_by(RankPoint.id.desc())
    last = session.scalar(newest.limit(1))
    if (None, None) == (last, rank) or (last and (last.rank, last.score) == (rank, score)):
        return
    people = score_counts.size(session, benchmark)
    point = RankPoint(user_id=user_id, benchmark=benchmark, at=time.time(), people=people)
    point.rank, point.score = rank, score
    session.add(point)
    session.flush()
    oldest = newest.with_only_columns(RankPoint.id).offset(KEPT - 1).limit(1)
    session.execute(delete(RankPoint).where(*whose, RankPoint.id < oldest.scalar_subquery()))


def _whose(user_id: int, benchmark: str) -> tuple[ColumnElement[bool], ...]:
    return RankPoint.user_id == user_id, RankPoint.benchmark == benchmark
