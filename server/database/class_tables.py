"""The tables of classes: who teaches, who belongs, what is assigned, which runs are for it."""

from typing import Any

from sqlalchemy import (
    JSON,
    BigInteger,
    CheckConstraint,
    ForeignKey,
    Index,
    Integer,
    String,
    Text,
    false,
)
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base

# SQLite autoincrements only columns of exactly this type.
_RowId = BigInteger().with_variant(Integer(), "sqlite")


class Classroom(Base):
    """A class. Whoever knows its code may join it."""

    __tablename__ = "classes"

    id: Mapped[int] = mapped_column(_RowId, primary_key=True)
    teacher_id: Mapped[int] = mapped_column(ForeignKey("users.id", ondelete="CASCADE"), index=True)
    name: Mapped[str] = mapped_column(String(80))
    code: Mapped[str] = mapped_column(String(16), unique=True)
    shows_ranking: Mapped[bool] = mapped_column(default=False, server_default=false())
    created_at: Mapped[float]
    archived_at: Mapped[float | None]

    __table_args__ = ({"sqlite_autoincrement": True},)  # ids stand in addresses: never reused


class Membership(Base):
    """A student of a class."""

    __tablename__ = "memberships"

    class_id: Mapped[int] = mapped_column(
        ForeignKey("classes.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    user_id: Mapped[int] = mapped_column(
        ForeignKey("users.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    joined_at: Mapped[float]

    __table_args__ = (Index("ix_memberships_user_id_class_id", "user_id", "class_id"),)


class Assignment(Base):
    """A task of a class: a benchmark with fixed settings, or its ranked runs."""

    __tablename__ = "assignments"

    id: Mapped[int] = mapped_column(_RowId, primary_key=True)
    class_id: Mapped[int] = mapped_column(ForeignKey("classes.id", ondelete="CASCADE"), index=True)
    title: Mapped[str] = mapped_column(String(120))
    instructions: Mapped[str] = mapped_column(Text, default="")
    benchmark: Mapped[str] = mapped_column(String(80))
    kind: Mapped[str] = mapped_column(String(10))
    config: Mapped[dict[str, Any]] = mapped_column(JSON)
    seed: Mapped[int | None] = mapped_column(BigInteger)  # NULL: ranked, or everybody's own
    trials: Mapped[int]
    deadline: Mapped[float | None]  # of the submission, not of its result; NULL: none
    created_at: Mapped[float]

    __table_args__ = (
        CheckConstraint("kind IN ('practice', 'ranked')", name="kind"),
        {"sqlite_autoincrement": True},
    )


class AssignedRun(Base):
    """A run that was submitted for an assignment. `score` is that of its result.

    It is repeated here so that the best runs of a class are read from the index alone.
    """

    __tablename__ = "assigned_runs"

    run_id: Mapped[int] = mapped_column(
        ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    assignment_id: Mapped[int] = mapped_column(ForeignKey("assignments.id", ondelete="CASCADE"))
    user_id: Mapped[int] = mapped_column(ForeignKey("users.id", ondelete="CASCADE"), index=True)
    score: Mapped[float | None]  # NULL until it has succeeded

    __table_args__ = (
        Index(
            "ix_assigned_runs_assignment_id_user_id", "assignment_id", "user_id", "score", "run_id"
        ),
    )
