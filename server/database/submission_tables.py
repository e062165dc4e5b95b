"""What is kept of submissions: sweeps, idempotency keys, and what has been seen of a program."""

from typing import Any

from sqlalchemy import JSON, BigInteger, ForeignKey, Index, String
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base, RowId


class KeyOfSubmission(Base):
    """What a submission with an Idempotency-Key has started."""

    __tablename__ = "submission_keys"

    user_id: Mapped[int] = mapped_column(
        ForeignKey("users.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    key: Mapped[str] = mapped_column(String(64), primary_key=True)  # SHA-256
    request: Mapped[str] = mapped_column(String(64))  # SHA-256 of what was submitted
    number: Mapped[int] = mapped_column(BigInteger)  # of the run or the sweep
    created_at: Mapped[float]

    __table_args__ = (Index("ix_submission_keys_user_id_created_at", "user_id", "created_at"),)


class SeenSubmission(Base):
    """A ranked submission whose fresh trials somebody could see; kept for good.

    Neither run nor user is referred to by a key: the row outlives both.
    """

    __tablename__ = "seen_submissions"

    submission: Mapped[str] = mapped_column(String(64), primary_key=True)
    run_id: Mapped[int] = mapped_column(BigInteger)  # the first one whose data could be seen
    digest: Mapped[str | None] = mapped_column(String(64))  # of its telemetry; NULL: it failed
    seen_at: Mapped[float]


class Sweep(Base):
    """A set of runs that differ in one or two settings or parameters."""

    __tablename__ = "sweeps"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    user_id: Mapped[int | None] = mapped_column(
        ForeignKey("users.id", ondelete="CASCADE"), index=True
    )
    guest: Mapped[str | None] = mapped_column(String(64))  # hash of the cookie
    benchmark: Mapped[str] = mapped_column(String(80))
    title: Mapped[str] = mapped_column(String(120), default="")
    axes: Mapped[list[dict[str, Any]]] = mapped_column(JSON(none_as_null=True))  # name, values
    created_at: Mapped[float]
