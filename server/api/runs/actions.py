"""Actions that change a run: rename, cancel, publish, withdraw, delete. Never by GET."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from flask import Response, jsonify, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Action
from seamark.server.api.requests import request_body
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import RunPath, RunResponse, run_answer
from seamark.server.api.runs.publication_schemas import PublicationRequest, VerificationRequested
from seamark.server.api.runs.run_lists import RunEdit
from seamark.server.runs.data import retention
from seamark.server.runs.ending import cancellation, deletion
from seamark.server.runs.publication.publications import PublicationRefused
from seamark.server.runs.recomputation.verifications import VerificationRefused
from seamark.server.runs.record import run_notes
from seamark.server.runs.showing import views
from seamark.server.web import access, publication
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

api = APIBlueprint(
    "api_actions",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Runs", description="Submit runs and follow them.")],
)


@api.post("/runs/<int:run_id>/cancel", responses={200: RunResponse})
def cancel(path: RunPath) -> dict[str, Any]:
    """Cancel a queued or running run. What it recorded so far is kept."""
    before = access.run_for(path.run_id, Action.CANCEL)
    held, by = services(), access.not_owner(before)
    if not cancellation.cancel(held.database, held.redis, path.run_id, not_owner=by):
        raise Problem("conflict", f"The run has already ended: it is {before.state.value}.")
    return _answer(path.run_id)


@api.post("/runs/<int:run_id>/publish", responses={200: RunResponse})
def publish(path: RunPath) -> dict[str, Any]:
    """Make a finished run public; a ranked one enters the leaderboard.

    An uploaded program needs the name of its method. Without a body, a run of a built-in solution
    or a log is published under your name.
    """
    wanted = PublicationRequest.model_validate({})
    if request.content_length:
        wanted = request_body.json_body(PublicationRequest)
    before = access.run_for(path.run_id, Action.PUBLISH)
    why_not = (
        "The run is already public."
        if before.public
        else "Only a finished run that has its data can be published."
    )
    try:
        _change(path.run_id, partial(publication.publish, terms=wanted.terms()), why_not)
    except PublicationRefused as refusal:
        errors = {refusal.field: str(refusal)}
        raise Problem("invalid-request", str(refusal), errors=errors) from None
    return _answer(path.run_id)


@api.post("/runs/<int:run_id>/verify", responses={202: VerificationRequested})
def verify(path: RunPath) -> Response:
    """Have a published ranked run evaluated again on fresh trials, behind the runs of all users.

    Each version of Seamark verifies a run once for its owner; admins may ask for more.
    """
    access.run_for(path.run_id, Action.VERIFY)
    try:
        publication.verify(path.run_id)
    except VerificationRefused as refusal:
        raise Problem("conflict", str(refusal)) from None
    address = f"/api/v1/runs/{path.run_id}/publication"
    answer = jsonify({"run": path.run_id, "publication": address})
    answer.status_code, answer.headers["Location"] = 202, address
    return answer


@api.post("/runs/<int:run_id>/reveal", responses={200: RunResponse})
def reveal(path: RunPath) -> dict[str, Any]:
    """Show who made a run that is published for review.

    With a ranked run, your other ranked runs of the same benchmark show your name as well.
    """
    access.run_for(path.run_id, Action.PUBLISH)
    _change(path.run_id, publication.reveal, "The run is not published anonymously.")
    return _answer(path.run_id)


@api.post("/runs/<int:run_id>/withdraw", responses={200: RunResponse})
def withdraw(path: RunPath) -> dict[str, Any]:
    """Make a public run private again and take it off the leaderboard."""
    access.run_for(path.run_id, Action.WITHDRAW)
    _change(path.run_id, publication.withdraw, "The run is not public.")
    return _answer(path.run_id)


@api.patch("/runs/<int:run_id>", responses={200: RunResponse})
def edit(path: RunPath, body: RunEdit) -> dict[str, Any]:
    """Change the title or the notes of a run, in any of its states."""
    access.run_for(path.run_id, Action.EDIT)
    with services().database.writing() as database:
        run_notes.annotate(database, path.run_id, **body.model_dump())
    return _answer(path.run_id)


@api.delete("/runs/<int:run_id>", responses={204: None})
def delete(path: RunPath) -> Response:
    """Delete a run with its data. It must have ended and be private. This cannot be undone.

    Quotas still count it, and so does the number of ranked submissions on the leaderboard.
    """
    access.run_for(path.run_id, Action.DELETE)
    current = services()
    if not deletion.delete(current.database, current.settings, [path.run_id]):
        raise Problem("conflict", deletion.WHY_NOT)
    return Response(status=204)


@api.delete("/runs/<int:run_id>/data", responses={200: RunResponse})
def delete_data(path: RunPath) -> dict[str, Any]:
    """Delete telemetry, log and program of a run; its result, metrics and configuration stay.

    The run must have ended and must not be public. This cannot be undone.
    """
    access.run_for(path.run_id, Action.DELETE_DATA)
    current = services()
    if not retention.delete(current.database, current.settings, [path.run_id]):
        raise Problem("conflict", retention.WHY_NOT)
    return _answer(path.run_id)


def _change(run_id: int, change: Callable[[Session, int], bool], why_not: str) -> None:
    with services().database.writing() as database:
        if not change(database, run_id):
            raise Problem("conflict", why_not)


def _answer(run_id: int) -> dict[str, Any]:
    with services().database.reading() as database:
        run = views.show(database, run_id, services().settings)
    if run is None:
        raise Problem("not-found")
    return run_answer(run)
