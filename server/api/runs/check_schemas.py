"""Request and response models of checks."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from seamark.programs.diagnostics import Diagnostic
from seamark.server.api.requests.query import Query
from seamark.server.api.requests.schemas import ResponseModel
from seamark.server.web.url_converters import ROW_ID_MAX


class CheckPath(BaseModel):
    """Path parameter of a check."""

    check_id: int = Field(ge=1, le=ROW_ID_MAX, description="Id of the check")


class CheckQuery(Query):
    """What is done, and how long the request waits for it."""

    run: bool = Field(True, description="false: only read the program; nothing is compiled or run")

    wait: float = Field(
        15.0, ge=0, le=15, description="Seconds to wait for the report before the response is 202"
    )


class CheckImageQuery(Query):
    """Which of the first images of a detector."""

    image: int = Field(0, ge=0, le=100, description="Counted from 0")


class ParameterResponse(ResponseModel):
    """A parameter of a program."""

    name: str
    type: Literal["number", "integer", "boolean"]
    default: float | int | bool
    low: float | None
    high: float | None
    unit: str
    description: str


class CheckResponse(ResponseModel):
    """A check. The report is complete when `state` is done; `id` is null if nothing was run."""

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
    images: list[str] = Field(
        default_factory=list,
        description="addresses of the first images that a detector was shown, with its answers",
    )
    parameters: list[ParameterResponse] = Field(
        default_factory=list, description="that the program declares; only in the answer to POST"
    )
