"""The tables of rejudgements; what is computed again are rows of `runs` with `rejudges`."""

from typing import Any

from sqlalchemy import JSON, CheckConstraint, ForeignKey, Index, String
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base, RowId

_Json = JSON(none_as_null=True)


class Rejudgement(Base):
    """A set of runs of one benchmark that are computed again, until an admin decides."""

    __tablename__ = "rejudgements"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    benchmark: Mapped[str] = mapped_column(String(80))
    reason: Mapped[str] = mapped_column(String(500))  # for the owners of the runs
    chosen: Mapped[dict[str, Any]] = mapped_column(_Json)  # by what the runs were chosen
    created_by: Mapped[str] = mapped_column(String(80))
    created_at: Mapped[float]
    decision: Mapped[str | None] = mapped_column(String(10))  # NULL: still to be made
    decided_by: Mapped[str | None] = mapped_column(String(80))
    decided_at: Mapped[float | None]

    __table_args__ = (
        CheckConstraint("decision IN ('accepted', 'discarded')", name="decision"),
        {"sqlite_autoincrement": True},
    )


class RejudgedRun(Base):
    """One computation of a rejudgement: how its result differs, and what it replaced."""

    __tablename__ = "rejudged_runs"

    run_id: Mapped[int] = mapped_column(  # not the run itself but the one that computes it again
        ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    rejudgement_id: Mapped[int] = mapped_column(ForeignKey("rejudgements.id", ondelete="CASCADE"))
    outcome: Mapped[str | None] = mapped_column(String(10))  # NULL: no result
    before: Mapped[dict[str, Any] | None] = mapped_column(_Json)
    after: Mapped[dict[str, Any] | None] = mapped_column(_Json)
    metrics: Mapped[list[str] | None] = mapped_column(_Json)  # paths of the first that differ
    metrics_count: Mapped[int] = mapped_column(default=0)  # that differ
    replaced_at: Mapped[float | None]
    earlier: Mapped[dict[str, Any] | None] = mapped_column(_Json)  # the result that was replaced

    __table_args__ = (
        CheckConstraint("outcome IN ('same', 'different')", name="outcome"),
        Index("ix_rejudged_runs_rejudgement_id_outcome", "rejudgement_id", "outcome", "run_id"),
    )
