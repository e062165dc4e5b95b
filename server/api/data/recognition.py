"""What a detector recognised: curves, confusion, times, and examples."""

from __future__ import annotations

from typing import Literal

from flask import Response, jsonify
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from pydantic import Field

from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import ResponseModel, RunPath
from seamark.server.runs.showing import recognition as recognitions
from seamark.server.web import access, caching

api = APIBlueprint(
    "api_recognition",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Data", description="The data of a run, at any time.")],
)


class TimeResponse(ResponseModel):
    """Wall time of an image [ms]; it depends on the machine and is no part of the result."""

    median: float
    longest: float


class RecognitionLevelResponse(ResponseModel):
    """A level, as means over the trials; the precision of a ranked run over the fresh ones."""

    value: float = Field(description="on the axis of difficulty, such as the optical depth")
    precision: list[float] = Field(
        description="interpolated, at each of `recalls`, mean over the classes; its mean is the "
        "average precision. Empty if no object counted"
    )
    time_ms: TimeResponse


class ExampleResponse(ResponseModel):
    """A moment of the run."""

    trial: int
    level: int
    t: float = Field(description="[s] in the trial")
    label: str
    corners: list[list[float]] = Field(
        description="[px] of the answer, or true ones of an object that was missed"
    )
    confidence: float | None = Field(description="of the answer")
    lies_on: str | None = Field(description="of a false alarm: class, decoy or background")


class RecognitionResponse(ResponseModel):
    """What a detector recognised in a run that has ended."""

    recalls: list[float]
    levels: list[RecognitionLevelResponse]
    labels: list[str] = Field(description="of the classes, columns of `confusion`")
    classes: list[str] = Field(description="their titles")
    lies_on: list[str] = Field(description="titles, rows of `confusion`")
    confusion: list[list[int]] = Field(
        description="how many answers of each class lie on what; ignored ones are left out"
    )
    objects: list[int] = Field(description="of each class that counted")
    missed: list[int] = Field(description="of these, how many no answer hit")
    examples: dict[Literal["false_alarms", "misses", "hits"], list[ExampleResponse]] = Field(
        description="the most confident false alarms, misses in the clearest water, and the least "
        "confident hits: eight each, at most two of a class"
    )
    images: int = Field(description="that all of this was computed from")
    recorded: int = Field(description="images of the run")


@api.get("/runs/<int:run_id>/recognition.json", responses={200: RecognitionResponse, 304: None})
def recognition(path: RunPath) -> Response:
    """Return what a detector recognised, once the run has ended. Has an ETag.

    There are no levels before that, and in runs of other programs than detectors.
    """
    view = access.run_for(path.run_id)
    answer = jsonify(recognitions.recognition(view, access.files_of(view)))
    answer.add_etag()
    return caching.conditional(answer)
