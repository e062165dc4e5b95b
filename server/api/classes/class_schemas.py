"""Request and response models of classes, assignments and the data of an account."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from seamark.server.accounts.accounts import NAME_MAX as USER_NAME_MAX
from seamark.server.api.requests.query import Query
from seamark.server.api.requests.schemas import CONFIG_MAX, ResponseModel, Text
from seamark.server.classes.assignments import INSTRUCTIONS_MAX, TITLE_MAX
from seamark.server.classes.classrooms import NAME_MAX
from seamark.server.web.url_converters import ROW_ID_MAX
from seamark.sim.engine.seeds import SEED_MAX


class ClassPath(BaseModel):
    """Path parameter of a class."""

    class_id: int = Field(ge=1, le=ROW_ID_MAX, description="Id of the class")


class PupilPath(ClassPath):
    """Path parameters of a student of a class."""

    user_id: int = Field(ge=1, le=ROW_ID_MAX, description="Id of the student's account")


class AssignmentPath(BaseModel):
    """Path parameter of an assignment."""

    assignment_id: int = Field(ge=1, le=ROW_ID_MAX, description="Id of the assignment")


class PupilsQuery(Query):
    """Pagination of students, in the order of their names."""

    after: str = Field("", max_length=USER_NAME_MAX, description="`next` of the previous page")


class ProgressQuery(PupilsQuery):
    """Pagination and format of what the students made of an assignment."""

    format: Literal["json", "csv"] = Field("json", description="csv: all students, with metrics")


class ExportQuery(Query):
    """What the archive of an account has."""

    telemetry: bool = Field(False, description="Include the recorded rows of all runs")


class ClassRequest(BaseModel):
    """A class to create."""

    model_config = ConfigDict(extra="forbid")

    name: Text = Field(min_length=1, max_length=NAME_MAX)


class ClassChange(BaseModel):
    """What to change about a class; omitted members stay."""

    model_config = ConfigDict(extra="forbid")

    name: Text | None = Field(None, min_length=1, max_length=NAME_MAX)
    shows_ranking: bool | None = Field(None, description="Students see the ranking, without names")
    archived: bool | None = Field(None, description="Nobody joins or submits any more")
    new_code: bool = Field(False, description="Replace the code; the old one stops working")


class JoinRequest(BaseModel):
    """The code of a class to join."""

    model_config = ConfigDict(extra="forbid")

    code: Text = Field(
        min_length=1, max_length=200, description="As the teacher gave it, or the link to join"
    )


class AssignmentRequest(BaseModel):
    """An assignment to create."""

    model_config = ConfigDict(extra="forbid")

    title: Text = Field(min_length=1, max_length=TITLE_MAX)
    instructions: Text = Field("", max_length=INSTRUCTIONS_MAX)
    benchmark: Text = Field(max_length=80, description="Name of a benchmark")
    kind: Literal["practice", "ranked"] = Field(
        "practice", description="ranked: the benchmark's scenario and seeds"
    )
    config: dict[str, Any] = Field(
        default_factory=dict,
        max_length=CONFIG_MAX,
        description="Settings of the scenario, fixed for all students; omitted ones have defaults",
    )
    seed: int | None = Field(
        None, ge=0, le=SEED_MAX, description="Practice only; every student's own if omitted"
    )
    trials: int = Field(1, ge=1, le=100, description="Practice only")
    deadline: float | None = Field(None, gt=0, lt=1e11, description="Seconds since 1970 (UTC)")


class AssignmentChange(BaseModel):
    """The description of an assignment; its settings cannot be changed."""

    model_config = ConfigDict(extra="forbid")

    title: Text = Field(min_length=1, max_length=TITLE_MAX)
    instructions: Text = Field("", max_length=INSTRUCTIONS_MAX)
    deadline: float | None = Field(None, gt=0, lt=1e11, description="Seconds since 1970 (UTC)")


class ClassResponse(ResponseModel):
    """A class; `code` and `join_url` are null for students."""

    id: int
    name: str
    teacher: str
    code: str | None
    join_url: str | None = Field(description="Where people join, also those without an account")
    pupils: int
    shows_ranking: bool
    created_at: float
    archived_at: float | None


class ClassesResponse(ResponseModel):
    """The classes that you teach and those that you are in."""

    taught: list[ClassResponse]
    joined: list[ClassResponse]


class AssignmentResponse(ResponseModel):
    """An assignment."""

    id: int
    class_id: int
    title: str
    instructions: str
    benchmark: str
    kind: Literal["practice", "ranked"]
    config: dict[str, Any]
    seed: int | None
    trials: int
    deadline: float | None
    closed: bool = Field(description="Runs no longer count for it")
    created_at: float


class AssignmentsResponse(ResponseModel):
    """The assignments of a class, newest first."""

    assignments: list[AssignmentResponse]


class PupilResponse(ResponseModel):
    """A student of a class."""

    user_id: int
    name: str
    joined_at: float


class PupilsResponse(ResponseModel):
    """A page of students, in the order of their names."""

    pupils: list[PupilResponse]
    next: str | None


class AssignedRunResponse(ResponseModel):
    """A run for an assignment."""

    run: int
    state: str
    program: str
    is_starter: bool = Field(description="The program is the starter, unchanged")
    seed: int | None
    queued_at: float
    score: float | None
    score_low: float | None
    score_high: float | None
    level_held: float | None


class ProgressResponse(ResponseModel):
    """A page of students with the number of their runs and the best one."""

    pupils: list[dict[str, Any]]
    next: str | None


class OwnRunsResponse(ResponseModel):
    """Your runs for an assignment, newest first, at most 100."""

    runs: list[AssignedRunResponse]


class RankingResponse(ResponseModel):
    """The best scores of the students, without names; `is_own` marks yours."""

    places: list[dict[str, Any]]
