"""The tables that a leaderboard is drawn from beside its rows: history, counts."""

from sqlalchemy import ForeignKey, Index, String
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base, RowId


class RankPoint(Base):
    """The rank that a user had at a time: a point of its history (leaderboard/rank_history.py)."""

    __tablename__ = "rank_points"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    user_id: Mapped[int] = mapped_column(ForeignKey("users.id", ondelete="CASCADE"))
    benchmark: Mapped[str] = mapped_column(String(80))
    at: Mapped[float]
    rank: Mapped[int | None]  # NULL: no published ranked run since then
    people: Mapped[int]  # on the leaderboard
    score: Mapped[float | None]

    __table_args__ = (Index("ix_rank_points_user_benchmark_id", "user_id", "benchmark", "id"),)


class ScoreCount(Base):
    """Number of people on a leaderboard in a class of scores (leaderboard/score_counts.py)."""

    __tablename__ = "score_counts"

    benchmark: Mapped[str] = mapped_column(String(80), primary_key=True)
    score_class: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    error_class: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    degrees: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    people: Mapped[int]
