"""Runs: order one, list them, look at one."""

from __future__ import annotations

import hashlib
from typing import Any, BinaryIO, cast

from flask import Response, jsonify
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from werkzeug.datastructures import FileStorage

from seamark.server.accounts.permissions import READ, SUBMIT, Action, can
from seamark.server.api import authorization, request_body
from seamark.server.api.schemas import (
    RunPath,
    RunRequest,
    RunResponse,
    RunsQuery,
    RunsResponse,
    run_answer,
)
from seamark.server.programs import store
from seamark.server.programs.store import StoredProgram, UploadRejected
from seamark.server.runs import submission, views
from seamark.server.runs.states import RunKind, RunState
from seamark.server.runs.submission import (
    UPLOAD,
    QuotaExceeded,
    Submission,
    SubmissionRejected,
    role_of,
)
from seamark.server.runs.views import RunFilter, RunView
from seamark.server.web import authentication, rate_limits
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.sim import registry
from seamark.sim.settings.configuration import ConfigurationInvalid

RUNNING_RETRY_S, QUEUED_RETRY_S = 1, 2  # how soon it is worth to look again

api = APIBlueprint(
    "api_runs",
    __name__,
    url_prefix="/api/v1",
    abp_tags=[Tag(name="Runs", description="Order runs and follow them.")],
)


@api.post("/runs", responses={202: RunResponse})
@rate_limits.limiter.limit(rate_limits.ORDER, key_func=rate_limits.who)
def create() -> Response:
    """Order a run of a built-in controller (JSON) or of a program (multipart).

    Guests may try built-in controllers; programs and ranked runs need an account.
    """
    limit = services().settings.upload_max_bytes
    order, file = request_body.json_or_multipart(
        RunRequest, json_part="run", file_part="program", file_max_bytes=limit
    )
    authorization.require_scope(SUBMIT)
    viewer = authentication.become_guest()
    if viewer.owner is None:
        raise Problem("unauthenticated")
    if file is not None and not can(viewer, Action.UPLOAD):
        raise Problem("account-needed", "Uploading a program needs an account.")
    if order.kind == "ranked" and not can(viewer, Action.SUBMIT_RANKED):
        raise Problem("account-needed", "A ranked run needs an account: it shows your name.")
    program = None if file is None else stored_program(file, order.benchmark)
    return _accepted(_enqueue(order, program))


def stored_program(file: FileStorage, benchmark: str) -> StoredProgram:
    """Return the stored program of a request; Problem if it is refused."""
    settings = services().settings
    if benchmark not in registry.BENCHMARKS:
        raise Problem("invalid-request", f"There is no benchmark {benchmark}.")
    try:
        return store.save_upload(
            cast("BinaryIO", file.stream),
            file.filename or "",
            limit=settings.upload_max_bytes,
            data=settings.data,
            role=role_of(benchmark),
        )
    except UploadRejected as reason:
        raise request_body.upload_problem(reason) from None


def _enqueue(order: RunRequest, program: StoredProgram | None) -> int:
    built_in = order.controller if program is None else None
    if program is None and built_in is None:
        needed = "Name a built-in controller, or send a program."
        raise Problem("invalid-request", needed, errors={"controller": needed})
    if program is not None and order.controller not in (None, UPLOAD):
        both = "Choose either a built-in controller or a program of your own."
        raise Problem("invalid-request", both, errors={"controller": both})
    return refused_in_words(
        Submission(
            viewer=authorization.viewer(),
            benchmark=order.benchmark,
            config=order.config,
            kind=RunKind(order.kind),
            controller=built_in or UPLOAD,
            program=program,
            seed=order.seed,
            trials=order.trials,
            title=order.title,
            notes=order.notes,
        )
    )


def refused_in_words(order: Submission | int) -> int:
    """Insert an order (or, given a run's id, the same order again) and return the new id.

    Raises
    ------
    Problem
        invalid-configuration, invalid-request or quota-exceeded.
    """
    settings = services().settings
    try:
        with services().database.writing() as database:
            if isinstance(order, int):
                run_id = submission.rerun(database, order, authorization.viewer(), settings)
            else:
                run_id = submission.enqueue(database, order, settings)
    except ConfigurationInvalid as wrong:
        raise Problem("invalid-configuration", str(wrong), errors=wrong.errors) from None
    except SubmissionRejected as reason:
        raise Problem("invalid-request", str(reason)) from None
    except QuotaExceeded as reason:
        wait = {"Retry-After": str(reason.retry_after_s)}
        raise Problem("quota-exceeded", str(reason), headers=wait) from None
    services().ring()  # only after the commit: the worker must find the row
    return run_id


def _accepted(run_id: int) -> Response:
    with services().database.reading() as database:
        view = views.show(database, run_id, services().settings)
    if view is None:
        raise Problem("not-found")
    answer = jsonify(run_answer(view))  # who ordered it may see it, whatever the token's scopes
    answer.status_code = 202
    answer.headers["Location"] = f"/api/v1/runs/{run_id}"
    answer.headers["Retry-After"] = str(QUEUED_RETRY_S)
    return answer


@api.post("/runs/<int:run_id>/rerun", responses={202: RunResponse})
def rerun(path: RunPath) -> Response:
    """Order the same run again; it is a new run with a number of its own."""
    authorization.run_for(path.run_id, Action.RERUN)
    return _accepted(refused_in_words(path.run_id))


@api.get("/runs", responses={200: RunsResponse})
def list_some(query: RunsQuery) -> dict[str, Any]:
    """List runs, newest first; pages are followed by `after` = `next`."""
    authorization.require_scope(READ)
    if query.which == "all" and not authorization.is_operator():
        raise Problem("forbidden", "Only admins may list the runs of all users.")
    with services().database.reading() as database:
        wanted = RunFilter(
            which=query.which,
            states=[RunState(state) for state in query.state],
            benchmark=query.benchmark,
            kind=query.kind,
        )
        page = views.page(
            database, authorization.viewer(), wanted, after=query.after, limit=query.limit
        )
    return {"runs": [run_answer(view, whole=False) for view in page.runs], "next": page.next}


@api.get("/runs/<int:run_id>", responses={200: RunResponse, 304: None})
def show(path: RunPath) -> Response:
    """Show a run: state, place in the line, progress, result, links. Has an ETag."""
    view = authorization.run_for(path.run_id)
    answer = jsonify(run_answer(view))
    answer.set_etag(hashlib.sha256(f"{view.id}-{view.version}".encode()).hexdigest()[:24])
    if not view.state.final:
        answer.headers["Retry-After"] = str(_retry_s(view))
    return authorization.conditional(answer)


def _retry_s(view: RunView) -> int:
    return RUNNING_RETRY_S if view.state is RunState.RUNNING else QUEUED_RETRY_S
