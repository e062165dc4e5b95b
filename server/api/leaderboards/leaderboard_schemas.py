"""Request and response models of leaderboards."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field, create_model

from seamark.server.api.requests.query import Query
from seamark.server.api.requests.schemas import ResponseModel
from seamark.server.api.runs.publication_schemas import VerificationResponse
from seamark.server.runs.leaderboard.board_rows import COLUMNS
from seamark.server.runs.leaderboard.leaderboard_filters import SORTED_MAX
from seamark.server.runs.leaderboard.per import Per


class RankQuery(Query):
    """Filters, order, pagination and format of the leaderboard."""

    per: Per = Field(
        Per.PERSON,
        description="One row for each `person`, with the best run, or for each named `method` of a "
        "person",
    )
    vehicle: str = Field("", max_length=40, description="Vehicle of the run, such as girona500")
    tracker: str = Field("", max_length=40, description="Built-in tracker of the run")
    language: str = Field("", max_length=40, description="Language of an uploaded program")
    program: Literal["", "uploaded", "built-in"] = Field("", description="Kind of program")
    baselines: Literal["", "hide", "only"] = Field(
        "", description="`hide` the reference entries, or show `only` these"
    )
    mine: bool = Field(False, description="Only the rows of the account")
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


ANSWERED = [column for column in COLUMNS if column.answered]
_METRICS = "metrics"  # an object in JSON, a column for each in the CSV
_FIELDS: dict[str, Any] = {
    one.answered: (one.type, Field(description=one.meaning)) for one in ANSWERED
}
_VERIFICATION = Field(description="the newest one; in the CSV its outcome alone")
if TYPE_CHECKING:
    RankResponse = ResponseModel
else:
    RankResponse = create_model(
        "RankResponse",
        __base__=ResponseModel,
        __doc__="A row of the leaderboard.",
        **_FIELDS,
        verification=(VerificationResponse | None, _VERIFICATION),
    )


def csv_columns() -> list[str]:
    """Return the columns of the CSV before those of the metrics."""
    names = [one.answered for one in ANSWERED if not one.after and one.answered != _METRICS]
    for one in ANSWERED:
        if one.after:
            names.insert(names.index(one.after) + 1, one.answered)
    return [*names, "verification"]


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
