"""Request and response models of leaderboards."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from seamark.server.api.requests.query import Query
from seamark.server.api.requests.schemas import ResponseModel
from seamark.server.api.runs.publication_schemas import VerificationResponse
from seamark.server.runs.leaderboard.leaderboard_filters import SORTED_MAX


class RankQuery(Query):
    """Filters, order, pagination and format of the leaderboard."""

    vehicle: str = Field("", max_length=40, description="Vehicle of the run, such as girona500")
    tracker: str = Field("", max_length=40, description="Built-in tracker of the run")
    language: str = Field("", max_length=40, description="Language of an uploaded program")
    program: Literal["", "uploaded", "built-in"] = Field("", description="Kind of program")
    baselines: Literal["", "hide", "only"] = Field(
        "", description="`hide` the reference entries, or show `only` these"
    )
    mine: bool = Field(False, description="Only the row of the account")
    sort: str = Field(
        "",
        max_length=80,
        description=f"Metric by which the first {SORTED_MAX} rows by score are sorted; by score if "
        "omitted. There is one page of such rows",
    )
    after: str | None = Field(None, max_length=120, description="`next` of the previous page")
    limit: int | None = Field(
        None, ge=1, le=500, description="50 if omitted; for CSV, all following rows"
    )
    format: Literal["json", "csv"] | None = Field(
        None, description="By the header Accept if omitted"
    )


class RankResponse(ResponseModel):
    """A row of the leaderboard."""

    rank: int | None = Field(
        description="null for reference entries, which are marks without a rank"
    )
    rank_low: int | None = Field(description="best rank that is compatible with all scores (95 %)")
    rank_high: int | None = Field(description="worst rank that is compatible with all scores")
    user: str
    method: str = Field(description="what the entry is called")
    controller: str = Field(description="name of the program's file, or of the built-in solution")
    run: int
    score: float
    score_low: float
    score_high: float
    level_held: float | None
    submissions: int = Field(description="ranked runs of this user in this benchmark that ended")
    reached_at: float
    is_baseline: bool
    title: str = Field(description="of the run")
    notes: str = Field(description="of the run: how its author describes the method")
    affiliation: str = Field(description="of the user")
    language: str = Field(description="of the uploaded program; empty for a built-in solution")
    vehicle: str
    tracker: str = Field(description="built-in tracker; empty if the program is the tracker")
    metrics: dict[str, float] = Field(description="by name, such as the benchmark lists them")
    anonymous: bool = Field(description="published for review: `user` is no name")
    verification: VerificationResponse | None = Field(
        description="the newest one; in the CSV its outcome alone"
    )


class ReferenceEntryResponse(ResponseModel):
    """A mark on the scale of a benchmark."""

    title: str
    score: float
    score_low: float
    score_high: float
    is_bound: bool = Field(description="such as doing nothing or the oracle: no run may use it")
    run: int | None = Field(
        description="null: a result that Seamark ships, not computed by this service"
    )


class RanksResponse(ResponseModel):
    """A page of the leaderboard."""

    benchmark: str
    ranks: list[RankResponse]
    reference_entries: list[ReferenceEntryResponse] = Field(description="best first, on every page")
    next: str | None
