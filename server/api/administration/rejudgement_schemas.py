"""Request and response models of rejudgements."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from seamark.server.administration import rejudge_choice
from seamark.server.administration.rejudge_choice import RunChoice
from seamark.server.administration.rejudgements import PAGE, PAGE_MAX, REASON_MAX
from seamark.server.api.requests.schemas import ResponseModel, Text
from seamark.server.web.url_converters import ROW_ID_MAX

_TIME_MAX = 1e11  # [s since 1970]


class RejudgementPath(BaseModel):
    """Path parameter of a rejudgement."""

    rejudgement_id: int = Field(ge=1, le=ROW_ID_MAX, description="Id of the rejudgement")


class ChoiceQuery(BaseModel):
    """Which runs are computed again; what is left out does not filter."""

    model_config = ConfigDict(extra="forbid")

    benchmark: Text = Field(min_length=1, max_length=80, description="For example currents-v3")
    kind: Literal["", "practice", "ranked"] = ""
    ended_from: float | None = Field(None, ge=0, le=_TIME_MAX, description="s since 1970")
    ended_to: float | None = Field(None, ge=0, le=_TIME_MAX, description="s since 1970, exclusive")
    language: Text = Field("", max_length=40, description="Of the program, or built-in")
    worker: Text = Field("", max_length=255, description="That computed the result")
    version: Text = Field("", max_length=40, description="Of Seamark, that computed the result")
    other_code: bool = Field(
        False,
        description="Choose only results that other simulator code than the service's has computed",
    )

    def choice(self) -> RunChoice:
        """Return the runs that are meant."""
        return RunChoice(**{name: getattr(self, name) for name in ChoiceQuery.model_fields})


class RejudgementRequest(ChoiceQuery):
    """A rejudgement to start."""

    reason: Text = Field(min_length=1, max_length=REASON_MAX, description="Owners can read it")


class RejudgementsQuery(BaseModel):
    """Pagination of rejudgements, newest first."""

    after: int | None = Field(None, ge=1, le=ROW_ID_MAX, description="`next` of the previous page")
    limit: int = Field(PAGE, ge=1, le=PAGE_MAX)


class PreviewResponse(ResponseModel):
    """What a rejudgement would compute again."""

    runs: int = Field(description=f"Those that match of the newest {rejudge_choice.RUNS_MAX}")
    complete: bool = Field(description="Whether all of the benchmark and period were looked at")
    machine_s: float = Field(description="Wall time that they took the first time, in total")
    data_bytes: int = Field(description="That they may record until the decision")


class RejudgementResponse(ResponseModel):
    """A rejudgement."""

    id: int
    benchmark: str
    reason: str
    chosen: dict[str, Any]
    created_by: str
    created_at: float
    decision: Literal["accepted", "discarded"] | None = Field(description="null: to be made")
    decided_by: str | None
    decided_at: float | None
    runs: int
    live: int = Field(description="Runs that are waiting or running")
    same: int = Field(description="Runs with the same result")
    different: int = Field(description="Runs with another result")
    failed: int = Field(description="Runs that were cancelled or could not be computed")
    part: float = Field(description="How much is done, 0 to 1")


class RejudgementsResponse(ResponseModel):
    """A page of rejudgements."""

    rejudgements: list[RejudgementResponse]
    next: int | None


class RankChangeResponse(ResponseModel):
    """A user's rank before and after; null: not on the leaderboard."""

    before: int | None
    after: int | None


class DifferenceResponse(ResponseModel):
    """A run whose result differs."""

    run_id: int
    user: str
    kind: Literal["practice", "ranked"]
    before: dict[str, Any] = Field(description="state, cause, score and digest")
    after: dict[str, Any]
    metrics: list[str] = Field(description="Paths of the first metrics that differ")
    metrics_count: int
    rank: RankChangeResponse | None = Field(description="null: unchanged by this, or decided")


class RecomputationResponse(ResponseModel):
    """That the result of a run was computed again."""

    at: float = Field(description="When the new result was accepted, s since 1970")
    reason: str
    outcome: Literal["same", "different"]
    earlier: dict[str, Any] | None = Field(description="The result that was replaced, if it was")
    metrics_count: int = Field(description="Metrics that differ")


class RecomputationsResponse(ResponseModel):
    """When and why the result of a run was computed again."""

    recomputations: list[RecomputationResponse]


class DifferencesResponse(ResponseModel):
    """A page of differences."""

    differences: list[DifferenceResponse]
    next: int | None
