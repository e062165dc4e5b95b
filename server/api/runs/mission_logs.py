"""Logs of real missions: opened here, then read, published and deleted like runs."""

from __future__ import annotations

from flask import Response, jsonify, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.mission_logs.result import LogRefused
from seamark.server.accounts.permissions import Action
from seamark.server.api.requests import refusals
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import RunResponse, run_answer
from seamark.server.runs.logs.log_reader import LogTooLarge
from seamark.server.runs.showing import views
from seamark.server.web import access, body_limits, rate_limits
from seamark.server.web.mission_logs import open_log
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

api = APIBlueprint(
    "api_mission_logs",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Runs", description="Submit runs and follow them.")],
)


@api.post("/logs", responses={201: RunResponse})
@rate_limits.limiter.limit(rate_limits.SUBMISSIONS, key_func=rate_limits.client)
def create() -> Response:
    """Open the log of a real mission: it is measured and becomes a run of the kind `log`.

    It is private until it is published, and never ranks. The answer comes when it is measured.
    """
    access.require(Action.UPLOAD)
    if request.mimetype != "multipart/form-data":
        raise Problem("unsupported-media-type", "Send multipart/form-data with the part `log`.")
    fields = body_limits.form_fields()
    try:
        with refusals.as_problems():
            run_id = open_log(
                request.files.get("log"),
                fields.get("mapping", ""),
                benchmark=fields.get("benchmark", ""),
                title=fields.get("title", ""),
                notes=fields.get("notes", ""),
            )
    except LogRefused as refusal:
        slug = "payload-too-large" if isinstance(refusal, LogTooLarge) else "log-refused"
        raise Problem(slug, str(refusal), errors={"log": str(refusal)}) from None
    with services().database.reading() as database:
        view = views.show(database, run_id, services().settings)
    if view is None:
        raise Problem("not-found")
    answer = jsonify(run_answer(view))
    answer.status_code = 201
    answer.headers["Location"] = f"/api/v1/runs/{run_id}"
    return answer
