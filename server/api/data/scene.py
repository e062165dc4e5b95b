"""What a view from outside needs of a run: its scene and the pictures of its surfaces."""

from __future__ import annotations

from typing import Any

from flask import Response, jsonify
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import RunPath, SceneQuery, TextureQuery
from seamark.server.programs import store
from seamark.server.runs.showing import scene as scenes
from seamark.server.runs.showing.views import RunView
from seamark.server.web import access, caching
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

_JSON: Any = {200: {"content": {"application/json": {"schema": {"type": "object"}}}}}
_JPEG: Any = {200: {"content": {"image/jpeg": {"schema": {"type": "string"}}}}}

api = APIBlueprint(
    "api_scene",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Data", description="The data of a run, at any time.")],
)


@api.get("/runs/<int:run_id>/scene.json", responses=_JSON)
def scene(path: RunPath, query: SceneQuery) -> Response:
    """Return vehicle, target, camera and water of a level: lengths in m, angles in rad."""
    view = _view(path, query)
    description = scenes.describe(services().settings, view, trial=query.trial, level=query.level)
    answer = jsonify(description)
    answer.add_etag()
    return caching.conditional(answer)


@api.get("/runs/<int:run_id>/texture.jpg", responses=_JPEG)
def texture(path: RunPath, query: TextureQuery) -> Response:
    """Return the picture of the seabed (columns to the north) or of the target's top face.

    The decoy's is that of the wrong box, where the right one has to be found.
    """
    view = _view(path, query)
    try:
        image = scenes.texture(
            services().settings, view, trial=query.trial, level=query.level, part=query.part
        )
    except scenes.NoDecoy as reason:
        raise Problem("not-found", str(reason)) from None
    answer = Response(image, content_type="image/jpeg")
    answer.add_etag()
    return caching.conditional(answer)


def _view(path: RunPath, query: SceneQuery) -> RunView:
    view = access.run_for(path.run_id)
    if not scenes.has_level(view, query.trial, query.level):
        raise Problem("not-found", f"Run {view.id} has no such trial or level.")
    if scenes.is_held_back(services().settings, view, query.trial):
        raise Problem("not-found", f"Trial {query.trial} of run {view.id} is not shown yet.")
    # What is drawn for a level also depends on a record of currents or a target picture.
    if not all(store.size(services().settings, one.sha256) for one in view.files):
        raise Problem("not-found", f"A file that run {view.id} needs has been deleted.")
    return view
