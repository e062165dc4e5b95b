"""What takes how much room, as it was measured last (server/runs/data/disk_usage.py)."""

from sqlalchemy import BigInteger, String
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base


class DiskUsage(Base):
    """A part of the service, an owner of runs, or what a rule of retention would delete."""

    __tablename__ = "disk_usage"

    kind: Mapped[str] = mapped_column(String(20), primary_key=True)
    name: Mapped[str] = mapped_column(String(80), primary_key=True)
    bytes: Mapped[int] = mapped_column(BigInteger)
    count: Mapped[int] = mapped_column(BigInteger)
