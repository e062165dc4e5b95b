"""Checks: compile a program and simulate two seconds with it, outside of every quota."""

from __future__ import annotations

import time
from typing import Any, BinaryIO, cast

from flask import Response, jsonify
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from werkzeug.datastructures import FileStorage

from seamark.server import workers
from seamark.server.accounts.permissions import READ, SUBMIT
from seamark.server.api import authorization, refusals, request_body
from seamark.server.api.schemas import CheckPath, CheckQuery, CheckResponse, RunRequest
from seamark.server.checks import queue, report
from seamark.server.checks.queue import CheckState, CheckView
from seamark.server.programs import store
from seamark.server.programs.store import PreparedProgram
from seamark.server.runs import submission
from seamark.server.runs.submission import SubmissionRejected
from seamark.server.web import rate_limits
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.settings.configuration import Configuration

LOOKS_S = (0.05, 0.05, 0.1, 0.1)  # [s] between looks at a check; then the last of:
LOOK_S = 0.2
RETRY_S = 1
_GONE = "There is no check {}; they are kept for an hour, and a new one replaces one that waits."

api = APIBlueprint(
    "api_checks",
    __name__,
    url_prefix="/api/v1",
    abp_tags=[Tag(name="Checks", description="Try a program before it is submitted.")],
)


@api.post("/checks", responses={200: CheckResponse, 202: CheckResponse})
@rate_limits.limiter.limit(rate_limits.CHECKS, key_func=rate_limits.client)
def create(query: CheckQuery) -> Response:
    """Check a program: read it, compile it, run two simulated seconds of the configuration.

    The form is that of `POST /runs`. What is wrong comes as `problems` with status 200; with 202
    it is not known yet: ask `Location` again. Costs nothing of the quota; one check at a time.
    """
    order, file = request_body.json_or_multipart(
        RunRequest,
        json_part="run",
        file_part="program",
        file_max_bytes=services().settings.upload_max_bytes,
    )
    authorization.require_scope(SUBMIT)
    with refusals.as_problems():
        submission.require_permission(authorization.viewer(), uploads=True)
        if file is None:
            raise SubmissionRejected("Send the program to be checked.", field="program")
        benchmark = submission.find_benchmark(order.benchmark)
        config = benchmark.read(order.config)
        prepared = _received(file, benchmark)
        if prepared.diagnostics:
            return jsonify(_done(benchmark.name, prepared))
        check_id = _enqueue(benchmark, config, prepared)
    return _answer(_waited_for(check_id, query.wait))


@api.get("/checks/<int:check_id>", responses={200: CheckResponse})
def show(path: CheckPath) -> Response:
    """Show one of your checks; `state` is done when there is an answer."""
    authorization.require_scope(READ)
    view = _view(path.check_id)
    answer = jsonify(_document(view))
    if view.state is not CheckState.DONE:
        answer.headers["Retry-After"] = str(RETRY_S)
    answer.headers["Cache-Control"] = "no-store"
    return answer


def _received(file: FileStorage, benchmark: Benchmark) -> PreparedProgram:
    """Read and lint a program; raises UploadRejected."""
    stream, limit = cast("BinaryIO", file.stream), services().settings.upload_max_bytes
    return store.read_upload(stream, file.filename or "", limit=limit, role=benchmark.role)


def _enqueue(benchmark: Benchmark, config: Configuration, prepared: PreparedProgram) -> int:
    """Queue a check and return its id; raises SubmissionRejected or CheckRefused."""
    held, user_id = services(), authorization.require_account()
    with held.database.reading() as session:
        submission.require_language(session, benchmark, prepared.language, held.settings)
    program = store.save(prepared, held.settings.data)
    values = config.model_dump(mode="json")
    with held.database.writing() as session:
        check_id = queue.enqueue(session, user_id, benchmark.name, values, program)
    queue.wake_worker(held.redis)
    return check_id


def _waited_for(check_id: int, seconds: float) -> CheckView:
    """Return the check when it is done, or after some seconds; at once if no worker is there."""
    with services().database.reading() as session:
        if not workers.alive_count(session):
            seconds = 0.0
    deadline = time.monotonic() + seconds
    looks = iter(LOOKS_S)
    while True:
        view = _view(check_id)
        left = deadline - time.monotonic()
        if view.state is CheckState.DONE or left <= 0:
            return view
        time.sleep(min(next(looks, LOOK_S), left))


def _view(check_id: int) -> CheckView:
    with services().database.reading() as session:
        view = queue.show(session, check_id, authorization.require_account())
    if view is None:
        raise Problem("not-found", _GONE.format(check_id))
    return view


def _answer(view: CheckView) -> Response:
    answer = jsonify(_document(view))
    if view.state is not CheckState.DONE:
        answer.status_code = 202
        answer.headers["Location"] = f"/api/v1/checks/{view.id}"
        answer.headers["Retry-After"] = str(RETRY_S)
    return answer


def _document(view: CheckView) -> dict[str, Any]:
    said = view.report or report.from_diagnostics([]) | {"ok": None}
    names = ("id", "benchmark", "program_name", "language")
    return {name: getattr(view, name) for name in names} | {"state": view.state.value} | said


def _done(benchmark: str, prepared: PreparedProgram) -> dict[str, Any]:
    """Return the document of a program whose text says enough."""
    about = {
        "id": None,
        "benchmark": benchmark,
        "program_name": prepared.name,
        "language": prepared.language,
        "state": CheckState.DONE.value,
    }
    return about | report.from_diagnostics(prepared.diagnostics)
