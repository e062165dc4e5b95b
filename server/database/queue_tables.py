"""The tables that make the queue cheap: whose turn it is, counters, durations."""

from sqlalchemy import BigInteger, Index, String, text
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base


class Turn(Base):
    """An owner with live runs, or who had one started today (server/runs/record/turns.py).

    The owner with the fewest running runs goes first, then the one served longest ago.
    """

    __tablename__ = "turns"

    owner: Mapped[str] = mapped_column(String(80), primary_key=True)
    served_at: Mapped[float]  # when a run of the owner was last claimed; 0: never
    priority: Mapped[int] = mapped_column(default=0, server_default="0")  # lower numbers go first
    queued: Mapped[int] = mapped_column(default=0, server_default="0")
    running: Mapped[int] = mapped_column(default=0, server_default="0")
    next_run: Mapped[int | None] = mapped_column(BigInteger)  # the oldest of the queued runs
    expected_s: Mapped[float] = mapped_column(default=0.0, server_default="0")  # of the queued runs

    @property
    def mean_s(self) -> float:
        """What a queued run of the owner is expected to take, on average."""
        return self.expected_s / self.queued if self.queued else 0.0

    __table_args__ = (
        Index(
            "ix_turns_next",
            *("priority", "running", "served_at", "next_run"),
            sqlite_where=text("queued > 0"),
            postgresql_where=text("queued > 0"),
        ),
        Index(
            "ix_turns_running",
            "priority",
            sqlite_where=text("running > 0"),
            postgresql_where=text("running > 0"),
        ),
        Index(
            "ix_turns_idle",
            "served_at",
            sqlite_where=text("queued = 0 AND running = 0"),
            postgresql_where=text("queued = 0 AND running = 0"),
        ),
    )


class Counter(Base):
    """A number that would cost a scan of a table."""

    __tablename__ = "counters"

    name: Mapped[str] = mapped_column(String(40), primary_key=True)
    value: Mapped[float]


class Pace(Base):
    """How long evaluations take: the mean of runs that succeeded (server/runs/queue/paces.py)."""

    __tablename__ = "paces"

    benchmark: Mapped[str] = mapped_column(String(80), primary_key=True)
    kind: Mapped[str] = mapped_column(String(10), primary_key=True)
    language: Mapped[str] = mapped_column(String(40), primary_key=True)  # "" for built-in ones
    wall_per_simulated: Mapped[float]  # [s/s]
    runs: Mapped[int]
