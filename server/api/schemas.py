"""What the HTTP interface reads and answers; the OpenAPI document is made from these classes."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from seamark.server.programs.diagnostics import Diagnostic
from seamark.server.runs.views import RunView
from seamark.sim.engine.seeds import SEED_MAX

ID_MAX = 2**53 - 1  # the largest whole number that every JSON reader keeps exactly


def _clean(text: str) -> str:
    """Refuse what no database can keep and no page can show: control and surrogate characters."""
    if any(ord(c) < 32 and c not in "\n\t" for c in text) or "\x7f" in text:
        raise ValueError("may not contain control characters")
    try:
        text.encode()
    except UnicodeEncodeError:
        raise ValueError("is not valid Unicode") from None
    return text


Text = Annotated[str, AfterValidator(_clean)]


class RunPath(BaseModel):
    """Which run."""

    run_id: int = Field(ge=1, le=ID_MAX, description="The run's number")


class BenchmarkPath(BaseModel):
    """Which benchmark."""

    benchmark: str = Field(min_length=1, max_length=80, description="For example currents-v1")


class TokenPath(BaseModel):
    """Which token."""

    token_id: int = Field(ge=1, le=ID_MAX, description="The token's number")


class RunRequest(BaseModel):
    """A run to be made."""

    model_config = ConfigDict(extra="forbid")

    benchmark: Text = Field(max_length=80, description="Name of a benchmark")
    config: dict[str, Any] = Field(
        default_factory=dict, description="Keys of the benchmark's schema; the rest has defaults"
    )
    controller: Text | None = Field(
        None, max_length=80, description="Built-in controller; left out when a program is sent"
    )
    seed: int | None = Field(
        None, ge=0, le=SEED_MAX, description="Practice only; drawn if left out"
    )
    trials: int = Field(
        1, ge=1, le=100, description="Practice only; ranked runs have a fixed number"
    )
    kind: Literal["practice", "ranked"] = Field("practice", description="Ranked: hidden seeds")
    title: Text = Field("", max_length=120)
    notes: Text = Field("", max_length=4000)


class RunsQuery(BaseModel):
    """Which runs to list."""

    which: Literal["mine", "public", "all"] = Field("mine", description="all: admins only")
    state: list[Literal["queued", "running", "succeeded", "failed", "cancelled"]] = Field(
        default_factory=list, description="May be given several times"
    )
    benchmark: str | None = Field(None, max_length=80)
    kind: Literal["practice", "ranked"] | None = None
    after: int | None = Field(None, ge=1, le=ID_MAX, description="`next` of the page before")
    limit: int = Field(50, ge=1, le=200)


class TelemetryQuery(BaseModel):
    """Which part of the telemetry."""

    start: int = Field(0, ge=0, le=ID_MAX, description="First row, to go on where one stopped")


class SeriesQuery(BaseModel):
    """Which columns, how fine."""

    columns: str = Field(
        "distance_px,error_x_px,error_y_px", max_length=2000, description="Names with commas"
    )
    max_points: int = Field(2000, ge=10, le=20000)
    trial: int = Field(0, ge=0, le=10000)


class LogQuery(BaseModel):
    """Which part of the log."""

    after: int = Field(0, ge=0, le=ID_MAX, description="X-Next-Offset of the answer before")


class CameraQuery(BaseModel):
    """Which picture."""

    trial: int = Field(0, ge=0, le=10000)
    t: float = Field(0.0, ge=0, le=1e7, description="Simulated time [s] since the trial began")


class DatasetQuery(BaseModel):
    """Which pictures."""

    trial: int = Field(0, ge=0, le=10000)
    every: int = Field(20, ge=1, le=10000, description="Control ticks between two pictures")
    begin: float = Field(0.0, ge=0, le=1e7, description="Simulated time [s] of the first")
    until: float | None = Field(None, ge=0, le=1e7, description="Before this time [s]; else all")
    colour: bool = Field(False, description="Else grey, as the trackers get them")


class RankQuery(BaseModel):
    """Which part of the leaderboard, in which form."""

    after: str | None = Field(None, max_length=120, description="`next` of the page before")
    limit: int | None = Field(
        None, ge=1, le=500, description="50 if left out; a CSV then has all that follow"
    )
    format: Literal["json", "csv"] | None = Field(
        None, description="Else the header Accept decides"
    )


Scope = Literal["read", "submit", "admin"]


def _ordinary_scopes() -> list[Scope]:
    return ["read", "submit"]


class TokenRequest(BaseModel):
    """A token to be made."""

    model_config = ConfigDict(extra="forbid")

    name: Text = Field("token", max_length=80)
    scopes: list[Scope] = Field(default_factory=_ordinary_scopes, min_length=1, max_length=3)
    days: float = Field(90, gt=0, le=3650)


class Answer(BaseModel):
    """What all answers have in common."""

    model_config = ConfigDict(extra="allow")


class BenchmarkResponse(Answer):
    """A benchmark; `schema` only when one is asked for."""

    name: str
    title: str
    summary: str
    links: dict[str, str]


class BenchmarksResponse(Answer):
    """All benchmarks."""

    benchmarks: list[BenchmarkResponse]


class RunResponse(Answer):
    """A run as the interface shows it. Times are seconds since 1970, UTC."""

    id: int
    state: Literal["queued", "running", "succeeded", "failed", "cancelled"]
    benchmark: str
    kind: str
    user: str
    controller: str
    seed: int | None
    trials: int
    progress: float
    t_simulated: float
    position: int | None
    estimate_s: float | None
    why_waiting: str | None
    result: dict[str, Any] | None
    failure: dict[str, Any] | None
    public: bool
    config: dict[str, Any]
    links: dict[str, str]


class CheckPath(BaseModel):
    """Which check."""

    check_id: int = Field(ge=1, le=ID_MAX, description="The check's number")


class CheckQuery(BaseModel):
    """How long to wait."""

    wait: float = Field(
        15.0, ge=0, le=15, description="Seconds to wait for the answer before 202 is answered"
    )


class CheckResponse(Answer):
    """A check; what it says is there when `state` is done. `id` is null if nothing had to run."""

    id: int | None
    state: Literal["queued", "running", "done"]
    benchmark: str
    program_name: str
    language: str
    ok: bool | None
    problems: list[Diagnostic]
    traceback: str
    output: str
    t_simulated: float
    usage: dict[str, float] | None
    step_us: dict[str, float] | None


class RunsResponse(Answer):
    """A page of runs, newest first."""

    runs: list[RunResponse]
    next: int | None


class SeriesResponse(Answer):
    """Thinned columns on one time axis; null where there is no number."""

    t: list[float]
    columns: dict[str, list[float | None]]
    rows: int
    final: bool


class RankResponse(Answer):
    """A row of the leaderboard."""

    rank: int
    tied: bool
    user: str
    controller: str
    run: int
    score: float
    score_low: float
    score_high: float
    level_held: float | None
    reached_at: float


class RanksResponse(Answer):
    """A page of the leaderboard."""

    benchmark: str
    ranks: list[RankResponse]
    next: str | None


class TokenResponse(Answer):
    """A token; `token` is its text, shown once when it is made."""

    id: int
    name: str
    scopes: list[str]
    created_at: float
    expires_at: float | None
    last_used_at: float | None
    token: str | None = None


class TokensResponse(Answer):
    """One's tokens, newest first."""

    tokens: list[TokenResponse]


class MeResponse(Answer):
    """Who asks, and what is left of the quotas."""

    name: str
    user_id: int | None
    is_admin: bool
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


_SHOWN = (
    *("id", "benchmark", "kind", "user", "is_baseline", "controller", "program_name", "language"),
    *("seed", "trials", "title", "notes", "rerun_of", "cause", "progress", "t_simulated"),
    *("position", "estimate_s", "why_waiting", "queued_at", "started_at", "finished_at"),
    *("attempt", "isolation", "public", "published_at", "config"),
)


def run_answer(view: RunView, *, whole: bool = True) -> dict[str, Any]:
    """Return the JSON of a run; lists go without metrics."""
    answer = {name: getattr(view, name) for name in _SHOWN}
    answer["state"] = view.state.value
    answer["result"] = _result(view)
    answer["failure"] = {"cause": view.cause, **view.detail} if view.cause else None
    if whole:
        answer["metrics"] = view.metrics
    answer["links"] = links_of(view.id)
    return answer


def _result(view: RunView) -> dict[str, Any] | None:
    if view.score is None and view.digest is None:
        return None
    names = ("score", "score_low", "score_high", "level_held", "digest")
    return {name: getattr(view, name) for name in names}
