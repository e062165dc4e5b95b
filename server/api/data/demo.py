"""The recorded demo: the same data as of a run, of the run that is shipped with the service."""

from __future__ import annotations

from typing import Any

from flask import Response, jsonify
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.api.data.series import series_of
from seamark.server.api.requests.file_answers import answers_with
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import (
    CameraQuery,
    DemoTextureQuery,
    MomentsResponse,
    SceneQuery,
    SeriesQuery,
    SeriesResponse,
    TrialQuery,
)
from seamark.server.runs.data.error_curve import error_column
from seamark.server.runs.showing import recorded_demo
from seamark.server.runs.showing.camera_view import Drawn
from seamark.server.runs.showing.moments import moments as find_moments
from seamark.server.web import caching
from seamark.server.web.services import services

api = APIBlueprint(
    "api_demo",
    __name__,
    url_prefix="/api/v1/demo",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Demo", description="The recorded run that the home page shows.")],
)


@api.get("/series.json", responses={200: SeriesResponse})
def series(query: SeriesQuery) -> dict[str, Any]:
    """Return columns of the recorded run, as series.json of a run does."""
    return series_of(recorded_demo.files(), query, final=True)


@api.get("/moments.json", responses={200: MomentsResponse})
def moments(query: TrialQuery) -> dict[str, Any]:
    """Return the moments of the recorded run, as moments.json of a run does."""
    error = error_column(recorded_demo.BENCHMARK)
    return find_moments(recorded_demo.files(), query.trial, error)


@api.get("/scene.json", responses=answers_with("application/json", "object"))
def scene(query: SceneQuery) -> Response:
    """Return the scene of the recorded run, which is the same in all levels."""
    return _conditional(jsonify(recorded_demo.scene()))


@api.get("/texture.jpg", responses=answers_with("image/jpeg"))
def texture(query: DemoTextureQuery) -> Response:
    """Return the picture of the seabed or of the target's top face."""
    return _conditional(_jpeg(recorded_demo.texture(query.part)))


@api.get("/camera.jpg", responses=answers_with("image/jpeg"))
def camera(query: CameraQuery) -> Response:
    """Return the camera image at a simulated time; a small one while the service starts."""
    drawn = Drawn(tracked=query.tracked, truth=query.truth)
    return _conditional(_jpeg(recorded_demo.camera_image(services().settings, query.t, drawn)))


def _jpeg(image: bytes) -> Response:
    return Response(image, content_type="image/jpeg")


def _conditional(answer: Response) -> Response:
    answer.add_etag()
    return caching.conditional(answer)
