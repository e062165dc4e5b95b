"""Request and response models of competitions, their boards, teams and entries."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from seamark.competitions.document import NAME_MAX as COMPETITION_NAME_MAX
from seamark.server.accounts.accounts import NAME_MAX as USER_NAME_MAX
from seamark.server.api.requests.query import Query
from seamark.server.api.requests.schemas import ResponseModel, Text
from seamark.server.competitions.competitions import REASON_MAX
from seamark.server.competitions.teams import NAME_MAX
from seamark.server.web.url_converters import ROW_ID_MAX

_AGREED = Field(description="That the members agree on the rules: must be true")


class CompetitionPath(BaseModel):
    """Path parameter of a competition."""

    name: str = Field(
        min_length=1, max_length=COMPETITION_NAME_MAX, description="For example harbour-cup-v1"
    )


class RoundPath(CompetitionPath):
    """Path parameters of a round."""

    number: int = Field(ge=1, le=ROW_ID_MAX, description="From 1")


class MemberPath(CompetitionPath):
    """Path parameters of a member of the own team."""

    user_id: int = Field(ge=1, le=ROW_ID_MAX, description="Id of the member's account")


class EntryPath(CompetitionPath):
    """Path parameters of an entry of the own team."""

    run_id: int = Field(ge=1, le=ROW_ID_MAX, description="Id of its run")


class BoardQuery(Query):
    """Rows and format of a board."""

    per: Literal["team", "method"] = Field(
        "team", description="One row for each `team`, with the best entry, or for each `method`"
    )
    format: Literal["json", "csv"] | None = Field(
        None, description="By the header Accept if omitted"
    )


class MoveRequest(BaseModel):
    """Another end of a round, or beginning of a final."""

    model_config = ConfigDict(extra="forbid")

    until: float = Field(gt=0, lt=1e11, description="Seconds since 1970 (UTC)")
    reason: Text = Field(min_length=1, max_length=REASON_MAX, description="Everybody sees it")


class HandOverRequest(BaseModel):
    """Who is to organise a competition."""

    model_config = ConfigDict(extra="forbid")

    user: Text = Field(min_length=1, max_length=USER_NAME_MAX, description="Name of the account")


class TeamRequest(BaseModel):
    """A team to found."""

    model_config = ConfigDict(extra="forbid")

    name: Text = Field(min_length=1, max_length=NAME_MAX)
    agree: Literal[True] = _AGREED


class TeamJoinRequest(BaseModel):
    """The code of a team to join."""

    model_config = ConfigDict(extra="forbid")

    code: Text = Field(
        min_length=1, max_length=200, description="As the captain gave it, or the link to join"
    )
    agree: Literal[True] = _AGREED


class TeamChange(BaseModel):
    """What to change about the own team; omitted members stay."""

    model_config = ConfigDict(extra="forbid")

    name: Text | None = Field(None, min_length=1, max_length=NAME_MAX)
    captain: int | None = Field(
        None, ge=1, le=ROW_ID_MAX, description="Id of the member's account that becomes captain"
    )
    new_code: bool = Field(False, description="Replace the code; the old one stops working")


class MoveResponse(ResponseModel):
    """That the organiser moved the end of a round, or the beginning of a final."""

    at: float
    before: float
    after: float
    reason: str


class RoundResponse(ResponseModel):
    """A round of a competition. Teams submit to all but a final."""

    number: int
    kind: Literal["practice", "qualification", "final"]
    opens_at: float
    closes_at: float | None = Field(description="null: a final")
    accepts: bool = Field(description="Teams can submit to it now")
    shows_board: bool = Field(description="Everybody sees its scores")
    trials: int = Field(description="of a submission; of a batch in a final")
    quota: int | None = Field(description="submissions of a team; null: a final")
    batches: int = Field(description="of a final, so far")
    commitment: str = Field(description="SHA-256 of the key that all seeds follow from")
    key: str | None = Field(description="null until the round is decided")
    decided_at: float | None
    moves: list[MoveResponse] = Field(description="of its time; not in the list of competitions")


class CompetitionSummary(ResponseModel):
    """A competition as the list shows it."""

    name: str
    title: str
    question: str
    organiser: str = Field(description="empty: the account was deleted")
    benchmark: str
    zone: str
    state: Literal["draft", "open", "ended"]
    teams: int
    own_team: str | None = Field(description="name of your team")
    current: int | None = Field(description="number of the round that accepts submissions now")
    rounds: list[RoundResponse]
    created_at: float
    opened_at: float | None
    ended_at: float | None
    links: dict[str, str]


class CompetitionResponse(CompetitionSummary):
    """A competition. What its document says never changes once it is open."""

    document: dict[str, Any] = Field(
        description="as it was written, complete; see docs/competitions.md"
    )
    digest: str = Field(description="SHA-256 of the canonical JSON of the document")
    vehicle_sha256: str | None = Field(description="of the organiser's own vehicle")
    files: dict[str, str] = Field(
        description="SHA-256 of the organiser's other files, by the settings that name them"
    )
    is_organiser: bool


class CompetitionsResponse(ResponseModel):
    """The open competitions and your own drafts, newest first."""

    competitions: list[CompetitionSummary]
    drafts: list[CompetitionSummary]


class FindingResponse(ResponseModel):
    """What a check has found."""

    level: Literal["good", "warning", "problem"]
    sentence: str


class ReferenceResponse(ResponseModel):
    """How a reference entry came out."""

    name: str
    title: str
    is_bound: bool = Field(description="such as doing nothing or the oracle: no run may use it")
    score: float | None
    failed_why: str


class CompetitionCheckResponse(ResponseModel):
    """How far the check of a draft is, and its report once it has ended."""

    ended: bool
    asked: int = Field(description="reference entries")
    waiting: int = Field(description="of them, which have not been evaluated yet")
    findings: list[FindingResponse] = Field(description="empty until it has ended")
    references: list[ReferenceResponse]


class BoardRowResponse(ResponseModel):
    """A row of a board."""

    place: int | None = Field(description="null: a reference entry, a failure, or it is hidden")
    place_low: int | None
    place_high: int | None
    team: str = Field(description="empty: a reference entry")
    method: str
    run: int
    score: float | None
    score_low: float | None
    score_high: float | None
    submitted_at: float
    submissions: int = Field(description="with a score")
    refusal: str | None = Field(description="why it has no score")
    own: bool = Field(description="of your team")


class BoardResponse(ResponseModel):
    """The board of a round, the best first. A hidden one has the rows of your team alone."""

    competition: str
    round: int
    per: Literal["team", "method"]
    hidden: bool
    decided: bool
    rows: list[BoardRowResponse]
    reference_entries: list[BoardRowResponse]


class MemberResponse(ResponseModel):
    """A member of a team."""

    user_id: int
    name: str
    joined_at: float
    captain: bool


class TeamResponse(ResponseModel):
    """Your team. Whoever knows its code may join it."""

    id: int
    competition: str
    name: str
    code: str
    join_url: str
    members: list[MemberResponse]


class EntryResponse(ResponseModel):
    """What your team submitted."""

    run: int
    round: int
    method: str
    user_id: int | None = Field(description="who submitted it")
    state: Literal["queued", "running", "succeeded", "failed", "cancelled"]
    cause: str | None
    submitted_at: float
    chosen: bool = Field(description="for the final")
    withdrawn_at: float | None
    refusal: str | None = Field(description="why it has no score")
    score: float | None
    score_low: float | None
    score_high: float | None
    charged: bool = Field(description="it counts for the quota of its round")


class EntriesResponse(ResponseModel):
    """What your team submitted, newest first."""

    entries: list[EntryResponse]
    left: int | None = Field(
        description="submissions that are left in the current round; null: none accepts any"
    )
