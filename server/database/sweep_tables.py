"""The table of sweeps; their runs are rows of `runs`."""

from typing import Any

from sqlalchemy import JSON, ForeignKey, String
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base, RowId


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
