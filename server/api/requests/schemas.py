"""Request and response models of the HTTP API; the OpenAPI document is generated from them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from seamark.competitions.document import NAME_MAX as COMPETITION_NAME_MAX
from seamark.programs import parts
from seamark.server.accounts import invitations, profiles
from seamark.server.accounts.accounts import NAME_MAX, TOKEN_DAYS, TOKEN_DAYS_MAX, TOKEN_NAME_MAX
from seamark.server.api.requests.query import Query
from seamark.server.runs.record.columns import PublicRun
from seamark.server.runs.record.entries import EntryAccess
from seamark.server.runs.record.method_names import METHOD_MAX
from seamark.server.runs.record.run_notes import NOTES_MAX, TITLE_MAX
from seamark.server.runs.showing.views import RunView
from seamark.server.web.url_converters import ROW_ID_MAX
from seamark.sim.engine.seeds import SEED_MAX

CONFIG_MAX = 200  # settings of a configuration; each unknown one is compared with all known


def _clean(text: str) -> str:
    """Reject control and surrogate characters, which cannot be stored or displayed."""
    if any(ord(c) < 32 and c not in "\n\t" for c in text) or "\x7f" in text:
        raise ValueError("may not contain control characters")
    try:
        text.encode()
    except UnicodeEncodeError:
        raise ValueError("is not valid Unicode") from None
    return text


Text = Annotated[str, AfterValidator(_clean)]


class RunPath(BaseModel):
    """Path parameter of a run."""

    run_id: int = Field(ge=1, le=ROW_ID_MAX, description="Id of the run")


class PartPath(RunPath):
    """Path parameters of a further program of a run."""

    role: str = Field(pattern=f"^({'|'.join(parts.ROLES)})$", description="What it is in the run")


class BenchmarkPath(BaseModel):
    """Path parameter of a benchmark."""

    benchmark: str = Field(min_length=1, max_length=80, description="For example currents-v1")


class TokenPath(BaseModel):
    """Path parameter of a token."""

    token_id: int = Field(ge=1, le=ROW_ID_MAX, description="Id of the token")


class RunRequest(BaseModel):
    """A run to submit."""

    model_config = ConfigDict(extra="forbid")

    benchmark: Text = Field(max_length=80, description="Name of a benchmark")
    config: dict[str, Any] = Field(
        default_factory=dict,
        max_length=CONFIG_MAX,
        description="Key -> value; omitted settings have defaults",
    )
    controller: Text | None = Field(
        None, max_length=80, description="Built-in controller or tracker; omit it to send a program"
    )
    seed: int | None = Field(
        None, ge=0, le=SEED_MAX, description="Practice runs only; random if omitted"
    )
    trials: int | None = Field(
        None, ge=1, le=100, description="Practice runs only, 1 if omitted; fixed for ranked runs"
    )
    kind: Literal["practice", "ranked"] = Field(
        "practice",
        description="ranked: the benchmark's scenario and seeds; other values are refused",
    )
    title: Text = Field("", max_length=TITLE_MAX)
    notes: Text = Field("", max_length=NOTES_MAX)
    assignment: int | None = Field(
        None, ge=1, le=ROW_ID_MAX, description="It fixes kind, scenario, seed and trials"
    )
    competition: Text | None = Field(
        None,
        max_length=COMPETITION_NAME_MAX,
        description="Whose current round your team submits to; it fixes kind, scenario, seed and "
        "trials",
    )
    method: Text = Field(
        "",
        max_length=METHOD_MAX,
        description="Name of the method that your team submits to a competition",
    )


class TelemetryQuery(Query):
    """Part of the telemetry."""

    start: int = Field(0, ge=0, le=ROW_ID_MAX, description="First row, to continue a download")


class SeriesQuery(Query):
    """Columns and resolution."""

    columns: str = Field(
        "distance_px,error_x_px,error_y_px", max_length=2000, description="Comma-separated names"
    )
    max_points: int = Field(2000, ge=10, le=20000)
    trial: int = Field(0, ge=0, le=10000)
    start: float = Field(0.0, ge=0, le=1e7, description="First simulated time [s] in the trial")
    stop: float = Field(1e7, ge=0, le=1e7, description="Last simulated time [s] in the trial")
    sample: Literal["extremes", "rows"] = Field(
        "extremes",
        description="extremes: least and greatest value of each interval, for charts; rows: whole "
        "rows at even distances and the last one, unchanged, for poses",
    )


class TrialQuery(Query):
    """One trial."""

    trial: int = Field(0, ge=0, le=10000)


class LogQuery(Query):
    """Part of the log."""

    after: int = Field(0, ge=0, le=ROW_ID_MAX, description="X-Next-Offset of the previous response")


class EventsQuery(Query):
    """Where a stream of events begins."""

    after: str = Field("", max_length=60, description="Id of an event, as in Last-Event-ID")


class CameraQuery(Query):
    """Trial and time of a camera image."""

    trial: int = Field(0, ge=0, le=10000)
    t: float = Field(0.0, ge=0, le=1e7, description="Simulated time [s] in the trial")
    tracked: bool = Field(True, description="Draw the outline that the tracker reported")
    truth: bool = Field(True, description="Draw the true outline")
    camera: Literal["vehicle", "arm", "sonar"] = Field(
        "vehicle",
        description="The vehicle's camera; or, without outlines, the one on its arm, or the fan of "
        "its imaging sonar",
    )


class SceneQuery(Query):
    """Trial and level of a scene."""

    trial: int = Field(0, ge=0, le=10000)
    level: int = Field(0, ge=0, le=10000)


class DemoTextureQuery(SceneQuery):
    """A surface of the recorded scene."""

    part: Literal["seabed", "target"] = Field("seabed", description="Which surface")


class TextureQuery(SceneQuery):
    """A surface of a scene."""

    part: Literal["seabed", "target", "decoy"] = Field("seabed", description="Which surface")


class DatasetQuery(Query):
    """Selection of camera images."""

    trial: int = Field(0, ge=0, le=10000)
    every: int = Field(20, ge=1, le=10000, description="Control steps between two images")
    begin: float = Field(0.0, ge=0, le=1e7, description="Simulated time [s] of the first image")
    until: float | None = Field(
        None, ge=0, le=1e7, description="Simulated end time [s]; default: all"
    )
    colour: bool = Field(False, description="Colour instead of greyscale")


Scope = Literal["read", "submit", "admin"]


def _default_scopes() -> list[Scope]:
    return ["read", "submit"]


class TokenRequest(BaseModel):
    """A token to create."""

    model_config = ConfigDict(extra="forbid")

    name: Text = Field("token", max_length=TOKEN_NAME_MAX)
    scopes: list[Scope] = Field(default_factory=_default_scopes, min_length=1, max_length=3)
    days: float = Field(TOKEN_DAYS, gt=0, le=TOKEN_DAYS_MAX, description="Until the token expires")


class InvitationsRequest(BaseModel):
    """Invitations to make."""

    model_config = ConfigDict(extra="forbid")

    count: int = Field(1, ge=1, le=invitations.BATCH_MAX)
    days: float = Field(
        invitations.DAYS, gt=0, le=invitations.DAYS_MAX, description="Until they expire"
    )


class ResponseModel(BaseModel):
    """Base class of all responses; more properties may be added."""

    model_config = ConfigDict(extra="allow")


class BenchmarkResponse(ResponseModel):
    """A benchmark; only the response for a single benchmark has its `schema`."""

    name: str
    title: str
    summary: str
    links: dict[str, str]


class BenchmarksResponse(ResponseModel):
    """All benchmarks."""

    benchmarks: list[BenchmarkResponse]


class RunEntryResponse(ResponseModel):
    """Where a run counts."""

    competition: str
    round: int = Field(description="its number; 0: the check of a draft")
    team: str | None = Field(description="null: a reference entry")
    method: str


class RunResponse(PublicRun, ResponseModel):
    """A run. Times are seconds since 1970, UTC."""

    entry: RunEntryResponse | None = Field(description="in a competition; not in lists")
    result: dict[str, Any] | None
    failure: dict[str, Any] | None
    links: dict[str, str]


class RunsResponse(ResponseModel):
    """A page of runs; with filters it may be short or empty before the last one."""

    runs: list[RunResponse]
    next: int | None
    next_skip: int = Field(description="0 unless the list is sorted by something else than time")


class SeriesResponse(ResponseModel):
    """Downsampled columns on a common time axis; null where there is no value."""

    t: list[float]
    columns: dict[str, list[float | None]]
    rows: int
    final: bool


class MomentsResponse(ResponseModel):
    """Moments of a trial so far; times are simulated ones in the trial [s]."""

    levels: list[dict[str, float]] = Field(description="`level` and `t` of its first row")
    largest_error: dict[str, Any] | None = Field(description="`column`, `t` and `value`")
    losses: list[float] = Field(
        description="When the tracker lost the target, or the vehicle its route; the first 200"
    )
    touches: list[float] = Field(description="When the hull first touched something in a level")
    completed: list[float] | None = Field(
        None, description="Where a route is followed: when it was completed in a level"
    )
    stages: list[dict[str, float]] | None = Field(
        None, description="Of interventions: `level`, `stage` from 0, and `t` when it was reached"
    )


class UserPath(BaseModel):
    """Path parameter of a user."""

    name: str = Field(min_length=1, max_length=NAME_MAX, description="Name of the account")


class UserQuery(Query):
    """Pagination of the published runs of a user."""

    after: int | None = Field(None, ge=1, le=ROW_ID_MAX, description="`next` of the previous page")
    limit: int = Field(50, ge=1, le=200)


class ProfileBody(BaseModel):
    """What a user says about themselves; empty values are not shown."""

    model_config = ConfigDict(extra="forbid")

    public_name: Text = Field("", max_length=profiles.NAME_MAX)
    affiliation: Text = Field("", max_length=profiles.AFFILIATION_MAX)
    paper_url: Text = Field("", max_length=profiles.URL_MAX, description="http or https")
    code_url: Text = Field("", max_length=profiles.URL_MAX, description="http or https")


class UserResponse(ResponseModel):
    """The public side of a user: profile, ranks, ids of published runs, newest first."""

    name: str
    public_name: str
    affiliation: str
    paper_url: str
    code_url: str
    ranks: list[dict[str, Any]] = Field(
        description="per benchmark: rank with its range, score, run, and `history` of the rank"
    )
    runs: list[int]
    next: int | None


class TokenResponse(ResponseModel):
    """A token; its text `token` is only returned on creation."""

    id: int
    name: str
    scopes: list[str]
    created_at: float
    expires_at: float | None
    last_used_at: float | None
    token: str | None = None


class TokensResponse(ResponseModel):
    """The tokens of the account, newest first."""

    tokens: list[TokenResponse]


class InvitationsResponse(ResponseModel):
    """Invitations; their texts are only returned on creation."""

    invitations: list[str]


class MeResponse(ResponseModel):
    """The authenticated user or guest and their quota."""

    name: str
    user_id: int | None
    role: Literal["anonymous", "guest", "user", "teacher", "organiser", "admin"]
    guest: bool
    scopes: list[str]
    quota: dict[str, int] | None
    csrf_token: str | None


_FILES = ("telemetry.csv", "telemetry.f64", "series.json", "metrics.json", "manifest.json")
_MORE = ("config.json", "log", "events", "camera.jpg")


def links_of(run_id: int) -> dict[str, str]:
    """Return name -> address of everything that belongs to a run."""
    base = f"/api/v1/runs/{run_id}"
    return {"self": base, "page": f"/runs/{run_id}"} | {
        name: f"{base}/{name}" for name in (*_FILES, *_MORE)
    }


def run_answer(view: RunView, *, whole: bool = True) -> dict[str, Any]:
    """Return the JSON of a run; lists go without metrics."""
    run = RunResponse(
        **{name: getattr(view, name) for name in PublicRun.model_fields},
        entry=None if view.entry is None else _entry(view.entry),
        result=_result(view),
        failure={"cause": view.cause, **view.detail} if view.cause else None,
        links=links_of(view.id),
    )
    return run.model_dump(mode="json", exclude=None if whole else {"metrics"})


def _entry(entry: EntryAccess) -> RunEntryResponse:
    return RunEntryResponse(
        competition=entry.competition,
        round=entry.round,
        team=None if entry.team_id is None else entry.team,
        method=entry.method,
    )


def _result(view: RunView) -> dict[str, Any] | None:
    if view.score is None and view.digest is None:
        return None
    names = ("score", "score_low", "score_high", "level_held", "digest", "error_curve")
    return {name: getattr(view, name) for name in names}
