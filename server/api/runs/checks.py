"""Checks: compile a program and simulate two seconds with it, without using up quota."""

from __future__ import annotations

import time
from typing import Any, BinaryIO, cast

import numpy as np
from flask import Response, jsonify
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from werkzeug.datastructures import FileStorage

from seamark.programs import check_report, configurations, parts
from seamark.programs.preparation import PreparedProgram
from seamark.server.accounts.permissions import Action
from seamark.server.api.requests import refusals, request_body
from seamark.server.api.requests.file_answers import answers_with
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import RunRequest
from seamark.server.api.runs.check_schemas import (
    CheckImageQuery,
    CheckPath,
    CheckQuery,
    CheckResponse,
)
from seamark.server.api.runs.vehicles import vehicle_of, with_vehicle
from seamark.server.messaging import workers
from seamark.server.programs import check_queue, store, vehicles
from seamark.server.programs.check_queue import CheckState, CheckView
from seamark.server.programs.vehicles import StoredVehicle
from seamark.server.runs.submission import submission, validation
from seamark.server.runs.submission.validation import SubmissionRejected
from seamark.server.web import access, caching, rate_limits
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.sim.benchmarks.benchmark import Benchmark

POLL_S = (0.05, 0.05, 0.1, 0.1)  # [s] first intervals between polls of the table
POLL_MAX_S = 0.2  # all further intervals
RETRY_S = 1
ONE_PROGRAM = "A check is of one program alone, in the role of the benchmark. Leave this one out."
_NOT_FOUND = (
    "You have no check {}. Checks are kept for an hour, and a new one replaces a queued one."
)

api = APIBlueprint(
    "api_checks",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Checks", description="Check a program before submitting it.")],
)


@api.post("/checks", responses={200: CheckResponse, 202: CheckResponse})
@rate_limits.limiter.limit(rate_limits.CHECKS, key_func=rate_limits.client)
def create(query: CheckQuery) -> Response:
    """Check a program: read it, compile it and run it for two simulated seconds.

    The request body is that of `POST /runs`. The report with its `problems` has status 200; status
    202 means that it is not ready yet: poll `Location`. Checks do not count against your quota; you
    can run one at a time. The answer also has the `parameters` that the program declares; with
    `run=false` it is only read, which takes no worker.
    """
    body, files = request_body.run_request(RunRequest)
    access.require_scope(Action.UPLOAD)
    with refusals.as_problems():
        validation.require_permission(access.viewer(), uploads="program")
        if files.program is None:
            raise SubmissionRejected("Send the program to check.", field="program")
        for role in files.parts:
            raise SubmissionRejected(ONE_PROGRAM, field=parts.field(role))
        benchmark = validation.find_benchmark(body.benchmark)
        prepared = _read_program(files.program, benchmark)
        declared = configurations.declared_in(benchmark, prepared.language, prepared.parameters)
        shown = {"parameters": [one.to_json() for one in declared]}
        if prepared.diagnostics or not query.run:
            return jsonify(_only_read(benchmark.name, prepared) | shown)
        vehicle = vehicle_of(files)
        config = with_vehicle(body.config, vehicle)
        with vehicles.lent(vehicle):
            values = configurations.read(benchmark, config, declared).document()
        check_id = _enqueue(benchmark, values, prepared, vehicle)
    return _response(_wait_for(check_id, query.wait), shown)


@api.get("/checks/<int:check_id>", responses={200: CheckResponse})
def show(path: CheckPath) -> Response:
    """Return one of your checks; the report is complete when `state` is done."""
    view = _view(path.check_id, access.require_account(Action.VIEW_ACCOUNT))
    response = jsonify(_document(view))
    if view.state is not CheckState.DONE:
        response.headers["Retry-After"] = str(RETRY_S)
    response.headers["Cache-Control"] = "no-store"
    return response


@api.get("/checks/<int:check_id>/camera.jpg", responses=answers_with("image/jpeg"))
def camera(path: CheckPath, query: CheckImageQuery) -> Response:
    """Render one of the first images that a detector was shown, with its answers drawn in."""
    from seamark.server.runs.showing import camera_view  # noqa: PLC0415 (it loads OpenCV)

    view = _view(path.check_id, access.require_account(Action.VIEW_ACCOUNT))
    seen = _seen(view)
    if query.image >= len(seen["rows"]):
        raise Problem("not-found", f"Check {view.id} has no image {query.image}.")
    row = np.array(seen["rows"][query.image], dtype=np.float64)  # None is NaN
    image = camera_view.render_row(view.benchmark, view.config, seen["seed"], row)
    answer = Response(image, content_type="image/jpeg")
    answer.add_etag()
    return caching.conditional(answer)


def _seen(view: CheckView) -> dict[str, Any]:
    seen: dict[str, Any] = (view.report or {}).get(check_queue.SEEN) or {"rows": []}
    return seen


def _read_program(file: FileStorage, benchmark: Benchmark) -> PreparedProgram:
    """Read and lint a program; raises UploadRejected."""
    stream, limit = cast("BinaryIO", file.stream), services().settings.upload_max_bytes
    owner, name = access.viewer().owner or "", file.filename or ""
    reader = services().reader
    return reader.read_upload(stream, name, owner=owner, limit=limit, role=benchmark.role)


def _enqueue(
    benchmark: Benchmark,
    values: dict[str, Any],
    prepared: PreparedProgram,
    vehicle: StoredVehicle | None,
) -> int:
    """Queue a check and return its id; raises SubmissionRejected or CheckRefused."""
    current, user_id = services(), access.require_account(Action.UPLOAD)
    with current.database.reading() as session:
        submission.require_language(session, benchmark, prepared.language, current.settings)
    program = store.save(prepared, current.settings)
    with current.database.writing() as session:
        check_id = check_queue.enqueue(session, user_id, benchmark.name, values, program, vehicle)
    check_queue.wake_worker(current.redis)
    return check_id


def _wait_for(check_id: int, seconds: float) -> CheckView:
    """Return the check when it is done or after `seconds`; immediately if no worker is alive."""
    with services().database.reading() as session:
        if not workers.alive_count(session):
            seconds = 0.0
    deadline, user_id = time.monotonic() + seconds, access.require_account(Action.UPLOAD)
    intervals = iter(POLL_S)
    while True:
        view = _view(check_id, user_id)
        remaining = deadline - time.monotonic()
        if view.state is CheckState.DONE or remaining <= 0:
            return view
        time.sleep(min(next(intervals, POLL_MAX_S), remaining))


def _view(check_id: int, user_id: int) -> CheckView:
    with services().database.reading() as session:
        view = check_queue.show(session, check_id, user_id)
    if view is None:
        raise Problem("not-found", _NOT_FOUND.format(check_id))
    return view


def _response(view: CheckView, more: dict[str, Any]) -> Response:
    response = jsonify(_document(view) | more)
    if view.state is not CheckState.DONE:
        response.status_code = 202
        response.headers["Location"] = f"/api/v1/checks/{view.id}"
        response.headers["Retry-After"] = str(RETRY_S)
    return response


def _document(view: CheckView) -> dict[str, Any]:
    report = view.report or check_report.from_diagnostics([]) | {"ok": None}
    names = ("id", "benchmark", "program_name", "language")
    shown = {name: value for name, value in report.items() if name != check_queue.SEEN}
    images = [
        f"/api/v1/checks/{view.id}/camera.jpg?image={at}" for at in range(len(_seen(view)["rows"]))
    ]
    known = {name: getattr(view, name) for name in names} | {"state": view.state.value}
    return known | shown | {"images": images}


def _only_read(benchmark: str, prepared: PreparedProgram) -> dict[str, Any]:
    """Return the document of a program that is not run."""
    check = {
        "id": None,
        "benchmark": benchmark,
        "program_name": prepared.name,
        "language": prepared.language,
        "state": CheckState.DONE.value,
    }
    return check | check_report.from_diagnostics(prepared.diagnostics)
