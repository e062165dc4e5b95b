"""Runs: submit one, list them, show one."""

from __future__ import annotations

import hashlib
import time
from typing import Any, BinaryIO, cast

from flask import Response, jsonify
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from sqlalchemy.orm import Session
from werkzeug.datastructures import FileStorage

from seamark.server.accounts.permissions import Action
from seamark.server.api.administration.rejudgement_schemas import RecomputationsResponse
from seamark.server.api.data.files import without_hidden_seeds
from seamark.server.api.requests import refusals, request_body
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.request_body import SubmissionHeaders, Uploads
from seamark.server.api.requests.schemas import (
    RunPath,
    RunRequest,
    RunResponse,
    RunsResponse,
    run_answer,
)
from seamark.server.api.runs.run_lists import RunsQuery
from seamark.server.api.runs.vehicles import vehicle_of, with_vehicle
from seamark.server.judging import entries
from seamark.server.programs.store import StoredProgram
from seamark.server.runs.recomputation import rejudged
from seamark.server.runs.recomputation.rejudged import Recomputation
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.showing import run_lists, views
from seamark.server.runs.showing.run_lists import ListCursor, RunFilter
from seamark.server.runs.showing.views import RunView
from seamark.server.runs.submission import assigned, submission, submission_keys, validation
from seamark.server.runs.submission.submission_keys import SubmissionKey
from seamark.server.runs.submission.validation import UPLOAD, Submission, SubmissionRejected
from seamark.server.web import access, authentication, caching, rate_limits, uploads
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

# What everybody who sees a run may see of an earlier result: not what its program printed.
EARLIER = (
    *("state", "cause", "digest", "score", "score_low", "score_high", "level_held"),
    *("not_ranked", "metrics", "manifest"),
)
RUNNING_RETRY_S, QUEUED_RETRY_S = 1, 2  # [s] until a client should ask again

api = APIBlueprint(
    "api_runs",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Runs", description="Submit runs and follow them.")],
)


@api.post("/runs", responses={202: RunResponse})
@rate_limits.limiter.limit(rate_limits.SUBMISSIONS, key_func=rate_limits.client)
def create(header: SubmissionHeaders) -> Response:
    """Submit a run of a built-in controller (JSON) or of a program (multipart).

    Guests may try built-in controllers; programs, vehicles and ranked runs need an account. A
    practice run may have a vehicle of your own, as the part `vehicle` of the multipart form. Where
    the benchmark has further roles, `tracker_program` and `detector_program` are programs of your
    own in place of the built-in solutions that the settings choose.
    """
    run, files = request_body.run_request(RunRequest)
    access.require_scope(Action.SUBMIT)
    with refusals.as_problems():
        sent = submission_of(run, files)
        return _accepted(_once(run, sent, header.submission_key(run, sent)))


def _once(run: RunRequest, sent: Submission, key: SubmissionKey | None) -> int:
    """Submit a run and return its number; of a repeated request that of the first."""
    settings, now = services().settings, time.time()
    with services().database.reading() as database:
        # Before the rest is looked at: the round may have closed since, or the quota be used up.
        known = None if key is None else submission_keys.number_of(database, key, now=now)
        if known is not None:
            return known
        counted = as_what_counts(database, run, sent)
    valid = validation.validate(counted, settings)
    with services().database.writing() as database:
        return submission_keys.once(
            database, key, lambda: submission.submit(database, valid, settings), now=now
        )


def submission_of(run: RunRequest, files: Uploads) -> Submission:
    """Return the submission in a request, whose programs and vehicle are stored.

    For what it is to count is not looked at yet.

    Raises
    ------
    SubmissionRejected, UploadRejected, VehicleRejected, QuotaExceeded, StorageUnavailable
        It is not permitted, or a file cannot be stored.
    """
    viewer, kind = authentication.become_guest(), RunKind(run.kind)
    vehicles = ("vehicle",) if files.vehicle else ()
    uploads = next(iter((*(("program",) if files.program else ()), *files.parts, *vehicles)), "")
    validation.require_permission(viewer, kind=kind, uploads=uploads)
    benchmark = validation.find_benchmark(run.benchmark)
    for role in files.parts:
        validation.check_part(benchmark, role)
    personal = run.competition is None
    if run.competition is not None:  # before anything is stored that no quota counts
        with services().database.reading() as database:
            entries.team_in(database, run.competition, viewer.user_id)
    program = None
    if files.program is not None:
        program = _store(files.program, benchmark.role, personal=personal)
    built_in = run.controller or (UPLOAD if program is not None else "")
    sent = run.model_dump(include={"benchmark", "seed", "trials", "title", "notes"})
    vehicle = vehicle_of(files)
    return Submission(
        viewer=viewer,
        kind=kind,
        controller=built_in,
        program=program,
        parts={
            role: _store_part(file, role, personal=personal) for role, file in files.parts.items()
        },
        vehicle=vehicle,
        config=with_vehicle(run.config, vehicle),
        **sent,
    )


def as_what_counts(database: Session, run: RunRequest, sent: Submission) -> Submission:
    """Return a submission with what its assignment or its competition fixes.

    Raises
    ------
    SubmissionRejected, ConfigurationInvalid
        The sender may not submit for it now, or sent something else than it asks for.
    """
    if run.competition is None:
        if run.method:
            raise SubmissionRejected(
                "A method has its name in a competition, or when a run is published.",
                field=entries.METHOD,
            )
        if run.assignment is None:
            return sent
        return assigned.for_assignment(database, run.assignment, sent)
    if run.assignment is not None:
        raise SubmissionRejected(
            "A run counts for an assignment or in a competition, not for both.",
            field=entries.FIELD,
        )
    access.require(Action.COMPETE)
    settings = services().settings
    return entries.for_competition(database, run.competition, run.method, sent, settings)


def _store(file: FileStorage, role: str, *, personal: bool) -> StoredProgram:
    """Store the program of a request."""
    stream, name = cast("BinaryIO", file.stream), file.filename or ""
    return uploads.store_program(stream, name, viewer=access.viewer(), role=role, personal=personal)


def _store_part(file: FileStorage, role: str, *, personal: bool) -> StoredProgram:
    stream, name = cast("BinaryIO", file.stream), file.filename or ""
    return uploads.store_part(stream, name, viewer=access.viewer(), role=role, personal=personal)


def _accepted(run_id: int) -> Response:
    """Announce a committed run to the workers and answer with it."""
    services().wake_worker()
    with services().database.reading() as database:
        view = views.show(database, run_id, services().settings)
    if view is None:
        raise Problem("not-found")
    answer = jsonify(run_answer(view))  # its owner may see it, whatever the scopes of the token
    answer.status_code = 202
    answer.headers["Location"] = f"/api/v1/runs/{run_id}"
    answer.headers["Retry-After"] = str(QUEUED_RETRY_S)
    return answer


@api.post("/runs/<int:run_id>/rerun", responses={202: RunResponse})
@rate_limits.limiter.limit(rate_limits.SUBMISSIONS, key_func=rate_limits.client)
def rerun(path: RunPath) -> Response:
    """Submit the same run again; it is a new run with its own number."""
    access.run_for(path.run_id, Action.RERUN)
    viewer, settings = access.viewer(), services().settings
    with refusals.as_problems(), services().database.writing() as database:
        run_id = submission.rerun(database, path.run_id, viewer, settings)
    return _accepted(run_id)


@api.get("/runs", responses={200: RunsResponse})
def list_some(query: RunsQuery) -> dict[str, Any]:
    """List runs; pages are followed by `after` = `next`, and `skip` = `next_skip` if it is sorted.

    Newest and oldest first, a list goes through all runs. Any other order sorts the newest 1000
    runs, then the 1000 before them.
    """
    access.require(Action.LIST)
    if query.which == "all":
        access.require(Action.ADMINISTER)
    with services().database.reading() as database:
        run_filter = RunFilter(
            which=query.which,
            states=[RunState(state) for state in query.state],
            benchmark=query.benchmark,
            kind=query.kind,
            program=query.program,
            text=query.q,
        )
        page = run_lists.page(
            database,
            access.viewer(),
            run_filter,
            order=query.sort,
            start=ListCursor(query.after, query.skip),
            limit=query.limit,
        )
    answers = [run_answer(view, whole=False) for view in page.runs]
    if page.next is None:
        return {"runs": answers, "next": None, "next_skip": 0}
    return {"runs": answers, "next": page.next.after, "next_skip": page.next.skip}


@api.get("/runs/<int:run_id>", responses={200: RunResponse, 304: None})
def show(path: RunPath) -> Response:
    """Show a run: state, position in the queue, progress, result, links. Has an ETag."""
    view = access.run_for(path.run_id)
    answer = jsonify(run_answer(view))
    answer.set_etag(hashlib.sha256(f"{view.id}-{view.version}".encode()).hexdigest()[:24])
    if not view.state.final:
        answer.headers["Retry-After"] = str(_retry_s(view))
    return caching.conditional(answer)


@api.get("/runs/<int:run_id>/recomputations", responses={200: RecomputationsResponse})
def list_recomputations(path: RunPath) -> dict[str, Any]:
    """List when and why the result was computed again, newest first, with what it replaced."""
    view = access.run_for(path.run_id)
    with services().database.reading() as database:
        history = rejudged.history(database, view.id)
    return {"recomputations": [_recomputation(each, view) for each in history]}


def _recomputation(recomputation: Recomputation, view: RunView) -> dict[str, Any]:
    names = ("at", "reason", "outcome", "metrics_count")
    shown = {name: getattr(recomputation, name) for name in names}
    if recomputation.earlier is None:
        return shown | {"earlier": None}
    earlier = {name: recomputation.earlier.get(name) for name in EARLIER}
    return shown | {"earlier": without_hidden_seeds(earlier, view)}


def _retry_s(view: RunView) -> int:
    return RUNNING_RETRY_S if view.state is RunState.RUNNING else QUEUED_RETRY_S
