"""The tables. Times are seconds since 1970 (UTC); JSON is for values that no query searches."""

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
    TextClause,
    UniqueConstraint,
    false,
    literal,
    text,
    true,
)
from sqlalchemy.orm import DeclarativeBase, Mapped, declared_attr, mapped_column, relationship
from sqlalchemy.schema import SchemaItem

from seamark.server.monitoring.log import request_id

# SQLite autoincrements only columns of exactly this type.
RowId = BigInteger().with_variant(Integer(), "sqlite")
_Json = JSON(none_as_null=True)
# PostgreSQL stores NaN and sorts it above every number: the bounds reject it, and infinity.
_FINITE = "{0} > -1e300 AND {0} < 1e300"


class Base(DeclarativeBase):
    """Base class of the tables; constraints have names, so that migrations can alter them."""

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
    """An account. `is_baseline` marks the owners of baseline runs."""

    __tablename__ = "users"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    name: Mapped[str] = mapped_column(String(40))
    name_key: Mapped[str] = mapped_column(String(80), unique=True)  # case-folded
    password_hash: Mapped[str | None] = mapped_column(Text)
    role: Mapped[str] = mapped_column(String(10), default="user", server_default="user")
    is_baseline: Mapped[bool] = mapped_column(default=False)
    created_at: Mapped[float]
    disabled_at: Mapped[float | None]  # by an admin: the account is refused everywhere
    quota_day: Mapped[int | None]  # runs in 24 h, instead of the setting
    notify_minutes: Mapped[int | None]  # e-mail about runs that took as long; NULL: none
    # What the page of the user shows; empty: nothing.
    public_name: Mapped[str] = mapped_column(String(80), default="", server_default="")
    affiliation: Mapped[str] = mapped_column(String(120), default="", server_default="")
    paper_url: Mapped[str] = mapped_column(String(300), default="", server_default="")
    code_url: Mapped[str] = mapped_column(String(300), default="", server_default="")

    __table_args__ = (
        CheckConstraint("role IN ('user', 'teacher', 'organiser', 'admin')", name="role"),
    )


class Token(Base):
    """An API token; only its SHA-256 is stored."""

    __tablename__ = "tokens"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    user_id: Mapped[int] = mapped_column(ForeignKey("users.id", ondelete="CASCADE"), index=True)
    name: Mapped[str] = mapped_column(String(80))
    hash: Mapped[str] = mapped_column(String(64), unique=True)
    scopes: Mapped[list[str]] = mapped_column(_Json)
    created_at: Mapped[float]
    expires_at: Mapped[float | None]
    last_used_at: Mapped[float | None]


class BrowserSession(Base):
    """A browser that is signed in; only the SHA-256 of what its cookie holds is stored."""

    __tablename__ = "browser_sessions"

    hash: Mapped[str] = mapped_column(String(64), primary_key=True)
    user_id: Mapped[int] = mapped_column(ForeignKey("users.id", ondelete="CASCADE"), index=True)
    created_at: Mapped[float]
    expires_at: Mapped[float]


class Invitation(Base):
    """An invitation to sign up; only its SHA-256 is stored. Deleted when it is used."""

    __tablename__ = "invitations"

    hash: Mapped[str] = mapped_column(String(64), primary_key=True)
    user_id: Mapped[int | None] = mapped_column(  # who invites; NULL: the operator
        ForeignKey("users.id", ondelete="CASCADE"), index=True
    )
    created_at: Mapped[float]
    expires_at: Mapped[float]


class Run(Base):
    """One evaluation of a controller or tracker. The queued rows are the queue."""

    __tablename__ = "runs"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    owner: Mapped[str] = mapped_column(String(80))  # "user:7" or "guest:<network>"
    user_id: Mapped[int | None] = mapped_column(ForeignKey("users.id"))
    guest: Mapped[str | None] = mapped_column(String(64))  # hash of the cookie
    benchmark: Mapped[str] = mapped_column(String(80))
    kind: Mapped[str] = mapped_column(String(10))
    config: Mapped[dict[str, Any]] = mapped_column(_Json)
    seed: Mapped[int | None] = mapped_column(BigInteger)  # NULL: ranked
    submission: Mapped[str | None] = mapped_column(String(64))  # digest, of fresh trials
    # Of a ranked run that has not ended: its worker needs no key that derives them.
    trial_seeds: Mapped[list[int] | None] = mapped_column(_Json, deferred=True)
    trials: Mapped[int]
    controller: Mapped[str] = mapped_column(String(80))
    program_sha256: Mapped[str | None] = mapped_column(String(64))
    program_name: Mapped[str | None] = mapped_column(String(255))
    language: Mapped[str | None] = mapped_column(String(40))
    program_parameters: Mapped[list[dict[str, Any]] | None] = mapped_column(
        _Json, deferred=True
    )  # that the program declares; their values are in `config`
    vehicle_sha256: Mapped[str | None] = mapped_column(String(64))  # a file of the user's
    title: Mapped[str] = mapped_column(String(120), default="")
    notes: Mapped[str] = mapped_column(Text, default="")
    # as published; kept when the run is withdrawn
    method: Mapped[str] = mapped_column(String(60), default="", server_default="")
    rerun_of: Mapped[int | None] = mapped_column(BigInteger)
    rejudges: Mapped[int | None] = mapped_column(BigInteger)  # hidden: computes this run again
    data_run: Mapped[int | None] = mapped_column(BigInteger)  # which recorded it; NULL: itself
    sweep_id: Mapped[int | None] = mapped_column(BigInteger)
    sweep_cell: Mapped[int | None]  # from 0, row by row (server/runs/submission/sweeps.py)
    expected_s: Mapped[float | None]  # wall time of its evaluation, estimated when submitted
    request_id: Mapped[str | None] = mapped_column(  # that queued it, for the logs
        String(64), default=request_id
    )

    state: Mapped[str] = mapped_column(String(10))
    cause: Mapped[str | None] = mapped_column(String(20))
    detail: Mapped[dict[str, Any]] = mapped_column(_Json, default=dict)
    queued_at: Mapped[float]
    started_at: Mapped[float | None]
    finished_at: Mapped[float | None]
    attempt: Mapped[int] = mapped_column(default=0)  # fencing token: incremented by each claim
    failures: Mapped[int] = mapped_column(default=0)  # evaluations that broke
    interruptions: Mapped[int] = mapped_column(default=0, server_default="0")  # lost workers, disks
    worker: Mapped[str | None] = mapped_column(String(255))
    lease_until: Mapped[float | None]
    progress: Mapped[float] = mapped_column(default=0.0)
    t_simulated: Mapped[float] = mapped_column(default=0.0)
    isolation: Mapped[str | None] = mapped_column(String(10))
    public: Mapped[bool] = mapped_column(default=False)
    published_at: Mapped[float | None]
    anonymous: Mapped[bool] = mapped_column(default=False, server_default=false())  # while public
    program_public: Mapped[bool] = mapped_column(default=True, server_default=true())
    licence: Mapped[str | None] = mapped_column(String(40))  # SPDX, of the program
    draw: Mapped[int | None]  # of fresh trials for the same submission; NULL: the first
    # [B] of its files and its program: an estimate from above until they are measured
    data_bytes: Mapped[int] = mapped_column(BigInteger, default=0, server_default="0")
    data_measured: Mapped[bool] = mapped_column(default=False, server_default=false())
    data_deleted_at: Mapped[float | None]  # telemetry, log and program; the row stays
    deleted_at: Mapped[float | None]  # an empty row stays (server/runs/ending/deletion.py)

    parts: Mapped[list["RunPart"]] = relationship(order_by="RunPart.role", passive_deletes=True)
    files: Mapped[list["RunFile"]] = relationship(order_by="RunFile.setting", passive_deletes=True)

    @property
    def has_programs(self) -> bool:
        """Whether programs were uploaded for it: one of its benchmark's role, or parts."""
        return self.program_sha256 is not None or bool(self.parts)

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
            "language",  # so that a claim reads the index alone
            sqlite_where=text("state = 'queued'"),
            postgresql_where=text("state = 'queued'"),
        ),
        Index(
            "ix_runs_running",
            "owner",
            sqlite_where=text("state = 'running'"),
            postgresql_where=text("state = 'running'"),
        ),
        Index(
            "ix_runs_queued_at",
            "queued_at",
            sqlite_where=text("state = 'queued'"),
            postgresql_where=text("state = 'queued'"),
        ),
        Index(
            "ix_runs_finished",
            "finished_at",
            "state",
            "t_simulated",  # so that counting what ended reads the index alone
            "rejudges",
            sqlite_where=text("finished_at IS NOT NULL"),
            postgresql_where=text("finished_at IS NOT NULL"),
        ),
        Index("ix_runs_state_id", "state", "id"),
        Index(
            "ix_runs_owner_id",
            "owner",
            "id",
            sqlite_where=text("deleted_at IS NULL"),
            postgresql_where=text("deleted_at IS NULL"),
        ),
        Index("ix_runs_owner_state_finished", "owner", "state", "finished_at"),  # the quota
        Index(
            "ix_runs_guest_id",
            "guest",
            "id",
            sqlite_where=text("guest IS NOT NULL"),
            postgresql_where=text("guest IS NOT NULL"),
        ),
        Index(
            "ix_runs_owner_bytes",
            "owner",
            "data_bytes",  # so that the disk space of an owner is summed from the index alone
            sqlite_where=text("data_bytes > 0"),
            postgresql_where=text("data_bytes > 0"),
        ),
        Index("ix_runs_public_id", "public", "id"),
        Index("ix_runs_owner_public_id", "owner", "public", "id"),
        Index(
            "ix_runs_sweep",
            "sweep_id",
            "sweep_cell",
            sqlite_where=text("sweep_id IS NOT NULL"),
            postgresql_where=text("sweep_id IS NOT NULL"),
        ),
        Index("ix_runs_program_sha256", "program_sha256"),  # for finding unused programs
        Index(
            "ix_runs_vehicle_sha256",
            "vehicle_sha256",
            sqlite_where=text("vehicle_sha256 IS NOT NULL"),
            postgresql_where=text("vehicle_sha256 IS NOT NULL"),
        ),
        Index("ix_runs_benchmark_state_id", "benchmark", "state", "id"),
        Index("ix_runs_benchmark_finished", "benchmark", "finished_at"),
        Index(
            "ix_runs_rejudges",
            "rejudges",
            sqlite_where=text("rejudges IS NOT NULL"),
            postgresql_where=text("rejudges IS NOT NULL"),
        ),
        Index("ix_runs_user_benchmark_kind_queued", "user_id", "benchmark", "kind", "queued_at"),
        Index(
            "ix_runs_submission",
            "submission",
            sqlite_where=text("submission IS NOT NULL"),
            postgresql_where=text("submission IS NOT NULL"),
        ),
    )


class RunPart(Base):
    """A further program of a run, in place of the built-in solution of its role."""

    __tablename__ = "run_parts"

    run_id: Mapped[int] = mapped_column(
        ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    role: Mapped[str] = mapped_column(String(20), primary_key=True)
    program_sha256: Mapped[str] = mapped_column(String(64), index=True)
    program_name: Mapped[str | None] = mapped_column(String(255))  # NULL: the run was deleted
    language: Mapped[str] = mapped_column(String(40))
    program_parameters: Mapped[list[dict[str, Any]] | None] = mapped_column(_Json)  # declared


class RunFile(Base):
    """A file that a setting of a run names, other than the vehicle's; the store has it."""

    __tablename__ = "run_files"

    run_id: Mapped[int] = mapped_column(
        ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    setting: Mapped[str] = mapped_column(String(40), primary_key=True)
    sha256: Mapped[str] = mapped_column(String(64), index=True)


# As the partial indexes have them: with a bound parameter no database would use these.
IS_QUEUED = Run.state == literal("queued", literal_execute=True)
IS_RUNNING = Run.state == literal("running", literal_execute=True)
# Runs that only compute others again are in no list and no count.
IS_LISTED = Run.rejudges.is_(None)


class Result(Base):
    """The result of a run; the primary key rules out a second one."""

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
    rankable: Mapped[bool] = mapped_column(default=False)  # by the rules of the benchmark
    not_ranked: Mapped[str | None] = mapped_column(Text)  # a sentence: why it is not rankable
    reference_scores: Mapped[list[float] | None] = mapped_column(_Json)  # of a ranked run's trials
    error_curve: Mapped[list[float | None] | None] = mapped_column(_Json)
    metrics: Mapped[dict[str, Any] | None] = mapped_column(_Json)
    manifest: Mapped[dict[str, Any] | None] = mapped_column(_Json)
    created_at: Mapped[float]

    __table_args__ = (
        CheckConstraint(f"score IS NULL OR ({_FINITE.format('score')})", name="finite"),
    )


class BoardRow:
    """A row of a leaderboard, as of the best published ranked run that it is about.

    Baselines are rows as well, but have no rank.
    """

    __tablename__: str

    benchmark: Mapped[str] = mapped_column(String(80), primary_key=True)
    user_id: Mapped[int] = mapped_column(
        ForeignKey("users.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    run_id: Mapped[int] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"))
    score: Mapped[float]
    score_low: Mapped[float]
    score_high: Mapped[float]
    standard_error: Mapped[float | None]  # of the score; NULL: unknown
    degrees: Mapped[int] = mapped_column(default=0, server_default="0")  # of freedom of the error
    is_baseline: Mapped[bool] = mapped_column(default=False, server_default=false())
    level_held: Mapped[float | None]
    # Ranked runs of the user in the benchmark that ended.
    submissions: Mapped[int] = mapped_column(default=1, server_default="1")
    reached_at: Mapped[float]
    # Copied from the run and its result: what rows are filtered and sorted by.
    language: Mapped[str] = mapped_column(String(40), default="", server_default="")  # "": built in
    vehicle: Mapped[str] = mapped_column(String(40), default="", server_default="")
    tracker: Mapped[str] = mapped_column(String(40), default="", server_default="")
    metrics: Mapped[dict[str, float] | None] = mapped_column(_Json)  # NULL: not computed yet

    @declared_attr.directive
    @classmethod
    def __table_args__(cls) -> tuple[SchemaItem, ...]:  # noqa: D105 - SQLAlchemy's
        name = cls.__tablename__
        return (
            CheckConstraint(_FINITE.format("score"), name="finite"),
            UniqueConstraint("run_id"),
            Index(
                f"ix_{name}_without_metrics",
                "run_id",
                sqlite_where=text("metrics IS NULL"),
                postgresql_where=text("metrics IS NULL"),
            ),
            Index(
                f"ix_{name}_rank",
                "benchmark",
                text("score DESC"),
                "reached_at",
                "run_id",
                "is_baseline",  # so that counting rows reads the index alone
            ),
            Index(
                f"ix_{name}_baselines",
                "benchmark",
                sqlite_where=text("is_baseline"),
                postgresql_where=text("is_baseline"),
            ),
        )


class Best(BoardRow, Base):
    """The best published ranked run of a user in a benchmark."""

    __tablename__ = "best"


class BestMethod(BoardRow, Base):
    """The best published ranked run of a method of a user in a benchmark; of a baseline, of all."""

    __tablename__ = "best_methods"

    # `method_names.key` of the run's; folding makes at most three characters of one.
    method: Mapped[str] = mapped_column(String(180), primary_key=True, sort_order=1)


def is_baseline(table: type[BoardRow]) -> TextClause:
    """Return the condition as the partial index has it; SQLite needs it to the letter."""
    return text(f"{table.__tablename__}.is_baseline")


IS_BASELINE = is_baseline(Best)


class Check(Base):
    """A check: two simulated seconds of a program before it is submitted. Deleted after an hour."""

    __tablename__ = "checks"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    user_id: Mapped[int] = mapped_column(ForeignKey("users.id", ondelete="CASCADE"), index=True)
    benchmark: Mapped[str] = mapped_column(String(80))
    config: Mapped[dict[str, Any]] = mapped_column(_Json)
    program_sha256: Mapped[str] = mapped_column(String(64))
    vehicle_sha256: Mapped[str | None] = mapped_column(String(64))
    program_name: Mapped[str] = mapped_column(String(255))
    language: Mapped[str] = mapped_column(String(40))
    state: Mapped[str] = mapped_column(String(10))
    queued_at: Mapped[float]
    finished_at: Mapped[float | None]
    attempt: Mapped[int] = mapped_column(default=0)  # fencing token: incremented by each claim
    worker: Mapped[str | None] = mapped_column(String(255))
    lease_until: Mapped[float | None]
    answer: Mapped[dict[str, Any] | None] = mapped_column(_Json)

    __table_args__ = (
        CheckConstraint("state IN ('queued', 'running', 'done')", name="state"),
        CheckConstraint("(state = 'done') = (answer IS NOT NULL)", name="answer"),
        Index("ix_checks_state_id", "state", "id"),
        {"sqlite_autoincrement": True},  # rows are deleted, and their ids must not be reused
    )


class Worker(Base):
    """A worker and what its host can enforce; alive while `seen_at` is recent."""

    __tablename__ = "workers"

    name: Mapped[str] = mapped_column(String(255), primary_key=True)
    slots: Mapped[int]
    level: Mapped[str] = mapped_column(String(10))
    languages: Mapped[list[str]] = mapped_column(_Json)
    findings: Mapped[list[dict[str, Any]]] = mapped_column(_Json)
    # language -> components, each with kind, name and version (sandbox/probing/self_test.py)
    contents: Mapped[dict[str, list[dict[str, str]]]] = mapped_column(
        _Json, default=dict, server_default="{}"
    )
    # side process -> "running", or what is wrong (see server/messaging/workers.py)
    processes: Mapped[dict[str, str]] = mapped_column(_Json, default=dict, server_default="{}")
    version: Mapped[str] = mapped_column(String(40), default="", server_default="")
    started_at: Mapped[float]
    seen_at: Mapped[float]
    drained_at: Mapped[float | None]  # by an admin: it claims no more runs
    result_code: Mapped[str | None] = mapped_column(Text)  # what it would compute
