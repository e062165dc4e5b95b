"""The tables of publications: what stays of them for ever, and how they were verified."""

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
    """A published run that the service evaluated again in fresh water."""

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
