"""The tables. Times are UTC seconds since 1970 as floats; JSON holds what is never searched."""

from typing import Any

from sqlalchemy import (
    JSON,
    BigInteger,
    CheckConstraint,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Text,
    UniqueConstraint,
    text,
)
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

# SQLite only counts rows up by itself in a column of exactly this type.
_Id = BigInteger().with_variant(Integer(), "sqlite")
_Json = JSON(none_as_null=True)
# PostgreSQL stores NaN and sorts it above every number: a bound keeps it (and infinity) out.
_FINITE = "{0} > -1e300 AND {0} < 1e300"


class Base(DeclarativeBase):
    """All tables; constraints have names, so that migrations can change them on SQLite."""

    metadata = MetaData(
        naming_convention={
            "ix": "ix_%(column_0_N_label)s",
            "uq": "uq_%(table_name)s_%(column_0_N_name)s",
            "ck": "ck_%(table_name)s_%(constraint_name)s",
            "fk": "fk_%(table_name)s_%(column_0_N_name)s",
            "pk": "pk_%(table_name)s",
        }
    )


class User(Base):
    """Somebody with an account. `is_baseline` marks the owner of the built-in entries."""

    __tablename__ = "users"

    id: Mapped[int] = mapped_column(_Id, primary_key=True)
    name: Mapped[str] = mapped_column(String(40))
    name_key: Mapped[str] = mapped_column(String(80), unique=True)  # case-folded
    password_hash: Mapped[str | None] = mapped_column(Text)
    is_admin: Mapped[bool] = mapped_column(default=False)
    is_baseline: Mapped[bool] = mapped_column(default=False)
    created_at: Mapped[float]


class Token(Base):
    """A key for programs; only its SHA-256 is kept."""

    __tablename__ = "tokens"

    id: Mapped[int] = mapped_column(_Id, primary_key=True)
    user_id: Mapped[int] = mapped_column(ForeignKey("users.id", ondelete="CASCADE"), index=True)
    name: Mapped[str] = mapped_column(String(80))
    hash: Mapped[str] = mapped_column(String(64), unique=True)
    scopes: Mapped[list[str]] = mapped_column(_Json)
    created_at: Mapped[float]
    expires_at: Mapped[float | None]
    last_used_at: Mapped[float | None]


class Run(Base):
    """One evaluation of one controller. The queued rows of this table are the queue."""

    __tablename__ = "runs"

    id: Mapped[int] = mapped_column(_Id, primary_key=True)
    owner: Mapped[str] = mapped_column(String(80))  # "user:7" or "guest:<hash>"
    user_id: Mapped[int | None] = mapped_column(ForeignKey("users.id"))
    guest: Mapped[str | None] = mapped_column(String(64))
    benchmark: Mapped[str] = mapped_column(String(80))
    kind: Mapped[str] = mapped_column(String(10))
    config: Mapped[dict[str, Any]] = mapped_column(_Json)
    seed: Mapped[int | None] = mapped_column(BigInteger)  # empty: ranked, on hidden seeds
    trials: Mapped[int]
    controller: Mapped[str] = mapped_column(String(80))
    program_sha256: Mapped[str | None] = mapped_column(String(64))
    program_name: Mapped[str | None] = mapped_column(String(255))
    language: Mapped[str | None] = mapped_column(String(40))
    title: Mapped[str] = mapped_column(String(120), default="")
    notes: Mapped[str] = mapped_column(Text, default="")
    rerun_of: Mapped[int | None] = mapped_column(BigInteger)

    state: Mapped[str] = mapped_column(String(10))
    cause: Mapped[str | None] = mapped_column(String(20))
    detail: Mapped[dict[str, Any]] = mapped_column(_Json, default=dict)
    queued_at: Mapped[float]
    started_at: Mapped[float | None]
    finished_at: Mapped[float | None]
    attempt: Mapped[int] = mapped_column(default=0)  # fencing token: one more at each claim
    failures: Mapped[int] = mapped_column(default=0)  # attempts that we, not the program, broke
    worker: Mapped[str | None] = mapped_column(String(255))
    lease_until: Mapped[float | None]
    cancel_requested: Mapped[bool] = mapped_column(default=False)  # of earlier versions, unused
    progress: Mapped[float] = mapped_column(default=0.0)
    t_simulated: Mapped[float] = mapped_column(default=0.0)
    isolation: Mapped[str | None] = mapped_column(String(10))
    public: Mapped[bool] = mapped_column(default=False)
    published_at: Mapped[float | None]

    __table_args__ = (
        CheckConstraint(
            "state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')", name="state"
        ),
        CheckConstraint("(state = 'failed') = (cause IS NOT NULL)", name="cause"),
        CheckConstraint("(kind = 'ranked') = (seed IS NULL)", name="hidden_seed"),
        Index(
            "ix_runs_queued",
            "owner",
            "id",
            "language",  # so that a claim is answered from the index alone
            sqlite_where=text("state = 'queued'"),
            postgresql_where=text("state = 'queued'"),
        ),
        Index(
            "ix_runs_running",
            "owner",
            sqlite_where=text("state = 'running'"),
            postgresql_where=text("state = 'running'"),
        ),
        Index("ix_runs_owner_id", "owner", "id"),
        Index("ix_runs_owner_state_finished", "owner", "state", "finished_at"),  # the quota
        Index("ix_runs_public_id", "public", "id"),
        Index("ix_runs_program_sha256", "program_sha256"),  # for who looks for unused programs
        Index("ix_runs_benchmark_state_id", "benchmark", "state", "id"),
    )


class Turn(Base):
    """When an owner's run was last started: who waited longest goes first."""

    __tablename__ = "turns"

    owner: Mapped[str] = mapped_column(String(80), primary_key=True)
    served_at: Mapped[float]


class Result(Base):
    """What an evaluation gave; the key makes a second result of one run impossible."""

    __tablename__ = "results"

    run_id: Mapped[int] = mapped_column(
        ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    attempt: Mapped[int]
    digest: Mapped[str | None] = mapped_column(String(64))
    score: Mapped[float | None]
    score_low: Mapped[float | None]
    score_high: Mapped[float | None]
    level_held: Mapped[float | None]
    rankable: Mapped[bool] = mapped_column(default=False)  # by the benchmark's own rules
    metrics: Mapped[dict[str, Any] | None] = mapped_column(_Json)
    manifest: Mapped[dict[str, Any] | None] = mapped_column(_Json)
    created_at: Mapped[float]

    __table_args__ = (
        CheckConstraint(f"score IS NULL OR ({_FINITE.format('score')})", name="finite"),
    )


class Best(Base):
    """The best public ranked run of a user in a benchmark: the leaderboard, kept up to date."""

    __tablename__ = "best"

    benchmark: Mapped[str] = mapped_column(String(80), primary_key=True)
    user_id: Mapped[int] = mapped_column(
        ForeignKey("users.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    run_id: Mapped[int] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"))
    score: Mapped[float]
    score_low: Mapped[float]
    score_high: Mapped[float]
    level_held: Mapped[float | None]
    reached_at: Mapped[float]

    __table_args__ = (
        CheckConstraint(_FINITE.format("score"), name="finite"),
        UniqueConstraint("run_id"),
        Index("ix_best_rank", "benchmark", text("score DESC"), "reached_at", "user_id"),
    )


class Check(Base):
    """Two seconds of a program before it is submitted; gone after an hour."""

    __tablename__ = "checks"

    id: Mapped[int] = mapped_column(_Id, primary_key=True)
    user_id: Mapped[int] = mapped_column(ForeignKey("users.id", ondelete="CASCADE"), index=True)
    benchmark: Mapped[str] = mapped_column(String(80))
    config: Mapped[dict[str, Any]] = mapped_column(_Json)
    program_sha256: Mapped[str] = mapped_column(String(64))
    program_name: Mapped[str] = mapped_column(String(255))
    language: Mapped[str] = mapped_column(String(40))
    state: Mapped[str] = mapped_column(String(10))
    queued_at: Mapped[float]
    finished_at: Mapped[float | None]
    attempt: Mapped[int] = mapped_column(default=0)  # fencing token: one more at each claim
    lease_until: Mapped[float | None]
    answer: Mapped[dict[str, Any] | None] = mapped_column(_Json)

    __table_args__ = (
        CheckConstraint("state IN ('queued', 'running', 'done')", name="state"),
        CheckConstraint("(state = 'done') = (answer IS NOT NULL)", name="answer"),
        Index("ix_checks_state_id", "state", "id"),
        {"sqlite_autoincrement": True},  # rows are deleted: an old number must not come again
    )


class Worker(Base):
    """A worker process and what its host can enforce; alive while `seen_at` is fresh."""

    __tablename__ = "workers"

    name: Mapped[str] = mapped_column(String(255), primary_key=True)
    slots: Mapped[int]
    level: Mapped[str] = mapped_column(String(10))
    languages: Mapped[list[str]] = mapped_column(_Json)
    findings: Mapped[list[dict[str, Any]]] = mapped_column(_Json)
    # side process -> "running", or what is wrong (see server/workers.py)
    processes: Mapped[dict[str, str]] = mapped_column(_Json, default=dict, server_default="{}")
    started_at: Mapped[float]
    seen_at: Mapped[float]
