"""Competitions: make a draft, have it checked, open it; move its rounds, hand it over."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from flask import Response, g, jsonify
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.accounts import accounts
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.accounts.audit import AuditAction
from seamark.server.accounts.permissions import Action
from seamark.server.api.competitions import competition_answers, draft_request
from seamark.server.api.competitions.competition_schemas import (
    CompetitionCheckResponse,
    CompetitionPath,
    CompetitionResponse,
    CompetitionsResponse,
    HandOverRequest,
    MoveRequest,
    RoundPath,
)
from seamark.server.api.requests import refusals, request_body
from seamark.server.api.requests.file_answers import answers_with
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.competitions import competitions, teams
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.judging import check, drafts
from seamark.server.runs.ending import deletion
from seamark.server.web import access, caching, competition_access, rate_limits
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

CHECK_RETRY_S = 5  # [s] until a client should ask again

api = APIBlueprint(
    "api_competitions",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Competitions", description="Competitions, their teams and boards.")],
)


@api.get("/competitions", responses={200: CompetitionsResponse})
def list_competitions() -> dict[str, Any]:
    """List the competitions that are open or have ended; an organiser's own drafts apart."""
    access.require(Action.LIST)
    user_id = g.viewer.user_id
    with services().database.reading() as database:
        listed = competitions.listed(database)
        drafted = []
        if user_id is not None and competition_access.may_organise():
            drafted = competitions.drafts_of(database, user_id)
        joined = {} if user_id is None else teams.memberships(database, user_id)
    return {
        "competitions": [
            competition_answers.summary(one, own_team=joined.get(one.id)) for one in listed
        ],
        "drafts": [competition_answers.summary(one, own_team=None) for one in drafted],
    }


@api.post("/competitions", responses={201: CompetitionResponse})
@rate_limits.limiter.limit(rate_limits.SUBMISSIONS, key_func=rate_limits.client)
def create_competition() -> Response:
    """Make a draft, which the reference entries check at once. Requires the role organiser.

    The document is the JSON body, or the part `document` of a multipart form, as JSON or as a TOML
    file. The form may have a `picture` (PNG or JPEG), the file of a `vehicle`, a
    `current_record`, and a picture for the `target_texture`.
    """
    user_id = access.require_account(Action.ORGANISE)
    settings = services().settings
    with refusals.as_problems():
        draft = draft_request.read()
        with services().database.writing() as database:
            name = drafts.create(database, user_id, draft, settings)
            access.record(database, AuditAction.COMPETITION_CREATED, name)
    services().wake_worker()
    answer = jsonify(competition_answers.answer(competition_access.shown(name)))
    answer.status_code = 201
    answer.headers["Location"] = f"/api/v1/competitions/{name}"
    return answer


@api.get("/competitions/<string:name>", responses={200: CompetitionResponse})
def show_competition(path: CompetitionPath) -> dict[str, Any]:
    """Show a competition that is open or has ended, or a draft of yours."""
    access.require(Action.LIST)
    return competition_answers.answer(competition_access.shown(path.name))


@api.put("/competitions/<string:name>", responses={200: CompetitionResponse})
@rate_limits.limiter.limit(rate_limits.SUBMISSIONS, key_func=rate_limits.client)
def replace_draft(path: CompetitionPath) -> dict[str, Any]:
    """Replace a draft of yours, which is checked again. The body is that of `POST /competitions`.

    Without a picture it keeps the one it has. An open competition never changes.
    """
    view, settings = competition_access.organised(path.name), services().settings
    with refusals.as_problems():
        draft = draft_request.read()
        with services().database.writing() as database:
            forgotten = drafts.change(database, view, draft, settings)
    deletion.remove_files(settings, forgotten)
    services().wake_worker()
    return competition_answers.answer(competition_access.shown(draft.document.name))


@api.delete("/competitions/<string:name>", responses={204: None})
def delete_draft(path: CompetitionPath) -> Response:
    """Delete a draft of yours. An open competition stays."""
    view = competition_access.organised(path.name)
    with refusals.as_problems(), services().database.writing() as database:
        forgotten = drafts.remove(database, view)
    deletion.remove_files(services().settings, forgotten)
    return Response(status=204)


@api.get("/competitions/<string:name>/check", responses={200: CompetitionCheckResponse})
def show_check(path: CompetitionPath) -> Response:
    """Tell how far the check of a competition of yours is, and what it found."""
    view = competition_access.organised(path.name)
    with services().database.reading() as database:
        seen = check.view(database, view)
    answer = jsonify(
        ended=seen.has_ended,
        asked=seen.asked,
        waiting=seen.waiting,
        findings=[asdict(finding) for finding in seen.findings],
        references=[
            {
                "name": each.name,
                "title": each.title,
                "is_bound": each.is_bound,
                "score": None if each.scores is None else each.score,
                "failed_why": "" if seen.waiting else each.failed_why,
            }
            for each in seen.references
        ],
    )
    if not seen.has_ended:
        answer.headers["Retry-After"] = str(CHECK_RETRY_S)
    return answer


@api.post("/competitions/<string:name>/open", responses={200: CompetitionResponse})
def open_competition(path: CompetitionPath) -> dict[str, Any]:
    """Open a draft of yours whose check has ended. From now on nobody can change what it asks."""
    view = competition_access.organised(path.name)
    with refusals.as_problems(), services().database.writing() as database:
        check.open_up(database, view)
        access.record(database, AuditAction.COMPETITION_OPENED, view.name, {"digest": view.digest})
    return competition_answers.answer(competition_access.shown(path.name))


@api.post(
    "/competitions/<string:name>/rounds/<int:number>/move", responses={200: CompetitionResponse}
)
def move_round(path: RoundPath) -> dict[str, Any]:
    """Move the end of a round, or the beginning of a final, to a later time, for a reason.

    Everybody sees it. Rounds that would begin before that end are moved as well.
    """
    view = competition_access.organised(path.name)
    body = request_body.json_body(MoveRequest)
    with refusals.as_problems(), services().database.writing() as database:
        competitions.move_round(database, view, path.number, body.until, body.reason)
        access.record(
            *(database, AuditAction.ROUND_MOVED, view.name),
            {"round": path.number, "until": body.until, "reason": body.reason},
        )
    return competition_answers.answer(competition_access.shown(path.name))


@api.post("/competitions/<string:name>/hand-over", responses={204: None})
def hand_over(path: CompetitionPath) -> Response:
    """Give a competition of yours to another organiser, who takes no part in it."""
    view = competition_access.organised(path.name)
    body = request_body.json_body(HandOverRequest)
    with refusals.as_problems(), services().database.writing() as database:
        competitions.hand_over(database, view, _user_id(body.user))
        detail = {"to": body.user}
        access.record(database, AuditAction.COMPETITION_HANDED_OVER, view.name, detail)
    return Response(status=204)


def _user_id(name: str) -> int:
    try:
        with services().database.reading() as database:
            return accounts.person(database, name).id
    except AccountRejected as refusal:
        raise CompetitionRefused(str(refusal), field="user") from None


@api.get("/competitions/<string:name>/picture", responses=answers_with("image/png"))
def picture(path: CompetitionPath) -> Response:
    """Return the picture of a competition, PNG or JPEG."""
    access.require(Action.LIST)
    view = competition_access.shown(path.name)
    content = _picture(view)
    answer = Response(content, content_type=drafts.media_type(content))
    answer.add_etag()
    return caching.conditional(answer)


def _picture(view: CompetitionView) -> bytes:
    with services().database.reading() as database:
        content = competitions.picture(database, view.id)
    if content is None:
        raise Problem("not-found", f"The competition {view.name} has no picture.")
    return content
