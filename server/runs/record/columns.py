"""The columns of a run as typed values, declared once for claims, views and the API.

A class here or derived from one is filled from loaded rows by `from_rows`; columns that it does not
have are ignored, columns that the query did not load keep their default.
"""

from typing import Any, Self

from pydantic import BaseModel, ConfigDict
from sqlalchemy import inspect

from seamark.server.database.tables import Base
from seamark.server.runs.record.states import RunKind, RunState


class RowValues(BaseModel):
    """Immutable values from the rows of one or more tables."""

    model_config = ConfigDict(frozen=True)

    @classmethod
    def from_rows(cls, *rows: Base | None, **values: object) -> Self:
        """Return the values; of columns with the same name that of the later row counts."""
        columns: dict[str, object] = {}
        for row in rows:
            columns |= {} if row is None else inspect(row).dict
        return cls.model_validate(columns | values)


class Part(RowValues):
    """A further program of a run, in place of the built-in solution of its role."""

    model_config = ConfigDict(from_attributes=True)

    role: str
    program_sha256: str
    program_name: str | None
    language: str
    program_parameters: list[dict[str, Any]] | None = None  # as the program declares them


class OwnFile(RowValues):
    """A file that a setting of a run names."""

    model_config = ConfigDict(from_attributes=True)

    setting: str
    sha256: str


class RunSpec(RowValues):
    """What is evaluated; never changes after the submission."""

    benchmark: str
    kind: RunKind
    config: dict[str, Any]  # with the parameters of the program below `parameters`
    seed: int | None  # None: ranked
    trials: int
    controller: str
    program_name: str | None
    language: str | None
    parts: tuple[Part, ...] = ()  # programs in further roles


class PublicRun(RunSpec):
    """What everybody sees of a public run, and the API answers. Times are s since 1970, UTC."""

    id: int
    user: str  # "guest" without an account
    is_baseline: bool
    title: str
    notes: str
    method: str = ""  # what it is called where it is published; empty: the same as its program
    rerun_of: int | None
    sweep_id: int | None = None  # the sweep that it belongs to
    state: RunState
    cause: str | None  # a FailureReason, when failed
    queued_at: float
    started_at: float | None
    finished_at: float | None
    attempt: int
    progress: float  # 0 to 1
    t_simulated: float  # [s] over all trials
    position: int | None = None  # in the queue, 1 is next; when queued
    estimate_s: float | None = None  # [s] until its end; None: unknown
    why_waiting: str | None = None
    isolation: str | None
    public: bool
    published_at: float | None
    anonymous: bool = False  # published for review: `user` is no name
    program_public: bool = True  # published with its program and log, not the results only
    licence: str | None = None  # SPDX identifier; None: none is granted here
    data_bytes: (
        int  # of its files and what was uploaded for it; an estimate from above until it has ended
    )
    data_deleted_at: float | None  # telemetry, log and program are gone since then
    metrics: dict[str, Any] | None = None
    program_parameters: list[dict[str, Any]] | None = None  # as the program declares them
    vehicle_sha256: str | None = None  # of the file of the user's own vehicle
    submission: str | None = None  # digest that the seeds of the fresh trials follow from
    not_ranked: str | None = None  # why it cannot be on the leaderboard, although it has a score
