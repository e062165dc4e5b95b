"""What everybody sees of users: publications with their verifications, and ranks over time."""

from sqlalchemy import ForeignKey, Index, String
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base, RowId


class Publication(Base):
    """That a run is or was public. The row outlives the run, so that its address can say so."""

    __tablename__ = "publications"

    run_id: Mapped[int] = mapped_column(RowId, primary_key=True, autoincrement=False)
    first_at: Mapped[float]  # its first publication
    withdrawn_at: Mapped[float | None]  # NULL: it is public


class Verification(Base):
    """A published run that the service evaluated again on fresh trials."""

    __tablename__ = "verifications"

    again_id: Mapped[int] = mapped_column(  # the hidden run that evaluates it again
        ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    run_id: Mapped[int] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"))
    requested_at: Mapped[float]
    ended_at: Mapped[float | None]  # NULL: it waits or runs, or broke because of the service
    version: Mapped[str | None] = mapped_column(String(40))  # of Seamark, that evaluated it
    digest: Mapped[str | None] = mapped_column(String(64))
    cause: Mapped[str | None] = mapped_column(String(20))  # why the program failed
    score: Mapped[float | None]
    score_low: Mapped[float | None]
    score_high: Mapped[float | None]
    standard_error: Mapped[float | None]
    degrees: Mapped[int] = mapped_column(default=0, server_default="0")

    __table_args__ = (Index("ix_verifications_run_id", "run_id", "again_id"),)


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
    """Number of rows of a leaderboard in a class of scores (leaderboard/score_counts.py)."""

    __tablename__ = "score_counts"

    benchmark: Mapped[str] = mapped_column(String(80), primary_key=True)
    score_class: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    error_class: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    degrees: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    people: Mapped[int]
    methods: Mapped[int] = mapped_column(default=0, server_default="0")
