"""The documents of the API that the client returns, as types for editors and type checkers.

A server may add keys; a test holds these to the OpenAPI document.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypedDict

RunState = Literal["queued", "running", "succeeded", "failed", "cancelled"]
Kind = Literal["practice", "ranked", "entry", "log"]
Values = str | Sequence[bool | int | float | str]  # of a sweep: a list or "from:to:count"


class SubmissionOptions(TypedDict, total=False):
    """What a submission may have beside the benchmark."""

    controller: str | None
    program: str | Path | None
    vehicle: str | Path | None
    tracker_program: str | Path | None
    detector_program: str | Path | None
    config: Mapping[str, object] | None
    kind: Literal["practice", "ranked"]
    seed: int | None
    trials: int | None
    title: str
    notes: str
    assignment: int | None
    competition: str | None
    method: str


class PublicationTerms(TypedDict):
    """On which terms a run is published."""

    method: str
    program: bool
    licence: str | None
    anonymous: bool


class RunDocument(TypedDict):
    """A run. Times are seconds since 1970, UTC; lists go without `metrics`."""

    id: int
    benchmark: str
    kind: Kind
    config: dict[str, Any]
    seed: int | None
    trials: int
    controller: str
    program_name: str | None
    language: str | None
    parts: list[dict[str, Any]]
    user: str
    is_baseline: bool
    title: str
    notes: str
    method: str
    rerun_of: int | None
    sweep_id: int | None
    state: RunState
    cause: str | None
    queued_at: float
    started_at: float | None
    finished_at: float | None
    attempt: int
    progress: float
    t_simulated: float
    position: int | None
    estimate_s: float | None
    why_waiting: str | None
    isolation: str | None
    public: bool
    published_at: float | None
    anonymous: bool
    program_public: bool
    licence: str | None
    data_bytes: int
    data_deleted_at: float | None
    metrics: dict[str, Any] | None
    program_parameters: list[dict[str, Any]] | None
    vehicle_sha256: str | None
    submission: str | None
    not_ranked: str | None
    entry: dict[str, Any] | None
    result: dict[str, Any] | None
    failure: dict[str, Any] | None
    links: dict[str, str]


class RunsQuery(TypedDict, total=False):
    """Filters of a list of runs."""

    which: Literal["mine", "public", "all"]
    state: Sequence[RunState]
    benchmark: str
    kind: Kind
    program: str
    q: str


class CellDocument(TypedDict):
    """A combination of values of a sweep; `run` is None if it has been deleted."""

    values: dict[str, Any]
    run: RunDocument | None


class SweepDocument(TypedDict):
    """A sweep."""

    id: int
    benchmark: str
    title: str
    axes: list[dict[str, Any]]
    created_at: float
    live: int
    best: int | None
    cells: list[CellDocument]
    links: dict[str, str]


class LeaderboardQuery(TypedDict, total=False):
    """Filters, order and pages of a leaderboard."""

    per: Literal["person", "method"]
    vehicle: str
    tracker: str
    language: str
    program: Literal["", "uploaded", "built-in"]
    baselines: Literal["", "hide", "only"]
    mine: bool
    sort: str
    after: str
    limit: int


class RankDocument(TypedDict):
    """A row of a leaderboard; baselines have no rank."""

    rank: int | None
    rank_low: int | None
    rank_high: int | None
    user: str
    method: str
    controller: str
    run: int
    score: float
    score_low: float
    score_high: float
    level_held: float | None
    submissions: int | None
    reached_at: float
    is_baseline: bool
    title: str
    notes: str
    affiliation: str
    language: str
    vehicle: str
    tracker: str
    metrics: dict[str, float]
    anonymous: bool
    verification: dict[str, Any] | None


class LeaderboardDocument(TypedDict):
    """A page of a leaderboard; `next` is the `after` of the following one."""

    benchmark: str
    ranks: list[RankDocument]
    reference_entries: list[dict[str, Any]]
    next: str | None


class CompareQuery(TypedDict, total=False):
    """What a comparison returns of the telemetry."""

    columns: str
    trial: int
    level: int
    max_points: int


class ComparisonDocument(TypedDict):
    """Runs side by side; the values of all rows are in the order of `runs`."""

    runs: list[RunDocument]
    note: str
    settings: list[dict[str, Any]]
    scores: list[dict[str, Any]]
    metrics: list[dict[str, Any]]
    levels: list[str]
    series: list[dict[str, Any]]


class BenchmarkDocument(TypedDict):
    """A benchmark; that of a single one has more keys, such as the `schema` of its settings."""

    name: str
    title: str
    summary: str
    links: dict[str, str]
