"""Rejudgements: preview, start, differences, accept, discard. All of it requires the role admin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any, TypeVar

from flask import Response
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Action
from seamark.server.administration import rejudge_choice, rejudgements
from seamark.server.administration.rejudgements import RejudgementRefused, RejudgementView
from seamark.server.api.administration.rejudgement_schemas import (
    ChoiceQuery,
    DifferencesResponse,
    PreviewResponse,
    RejudgementPath,
    RejudgementRequest,
    RejudgementResponse,
    RejudgementsQuery,
    RejudgementsResponse,
)
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.web import access, csv_export, rejudgement_csv
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

Answer = TypeVar("Answer")
api = APIBlueprint(
    "api_rejudgements",
    __name__,
    url_prefix="/api/v1/admin/rejudgements",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Rejudgements", description="Computing a set of runs again.")],
)


@api.before_request
def _only_admins() -> None:
    access.require(Action.ADMINISTER)


@api.get("", responses={200: RejudgementsResponse})
def list_all(query: RejudgementsQuery) -> dict[str, Any]:
    """List rejudgements, newest first."""
    with services().database.reading() as session:
        listed, following = rejudgements.page(session, after=query.after, limit=query.limit)
    return {"rejudgements": [_answer(view) for view in listed], "next": following}


@api.get("/preview", responses={200: PreviewResponse})
def preview(query: ChoiceQuery) -> dict[str, Any]:
    """Return how many runs a rejudgement would compute again, and what that takes."""
    with services().database.reading() as session:
        chosen = rejudge_choice.choose(session, query.choice())
    return asdict(chosen) | {"runs": len(chosen.runs)}


@api.post("", responses={201: RejudgementResponse})
def create(body: RejudgementRequest) -> tuple[dict[str, Any], int]:
    """Start a rejudgement. Nothing changes before it is accepted."""
    held, actor = services(), access.actor()
    with held.database.writing() as session:
        number = _or_conflict(
            lambda: rejudgements.start(session, actor, body.choice(), body.reason, held.settings)
        )
        answer = _answer(_view(session, number))
    held.wake_worker()
    return answer, 201


@api.get("/<int:rejudgement_id>", responses={200: RejudgementResponse})
def show(path: RejudgementPath) -> dict[str, Any]:
    """Return a rejudgement with its progress."""
    with services().database.reading() as session:
        return _answer(_view(session, path.rejudgement_id))


@api.get("/<int:rejudgement_id>/differences", responses={200: DifferencesResponse})
def list_differences(path: RejudgementPath, query: RejudgementsQuery) -> dict[str, Any]:
    """List the runs whose result differs, with ranks as they would be."""
    with services().database.reading() as session:
        row = _view(session, path.rejudgement_id).row
        differing = rejudgements.differences(session, row, after=query.after, limit=query.limit)
    following = differing[-1].key if len(differing) == query.limit else None
    return {"differences": [asdict(each) for each in differing], "next": following}


@api.get("/<int:rejudgement_id>/differences.csv")
def download_differences(path: RejudgementPath) -> Response:
    """Download all differences as CSV."""
    with services().database.reading() as session:
        row = _view(session, path.rejudgement_id).row
        differing = list(rejudgements.all_differences(session, row))
    answer = Response(rejudgement_csv.lines(differing), mimetype=csv_export.MEDIA_TYPE)
    name = f"seamark-rejudgement-{path.rejudgement_id}.csv"
    answer.headers["Content-Disposition"] = f'attachment; filename="{name}"'
    return answer


@api.post("/<int:rejudgement_id>/accept", responses={200: RejudgementResponse})
def accept(path: RejudgementPath) -> dict[str, Any]:
    """Replace the results that differ. The earlier results are kept."""
    return _decide(rejudgements.accept, path.rejudgement_id)


@api.post("/<int:rejudgement_id>/discard", responses={200: RejudgementResponse})
def discard(path: RejudgementPath) -> dict[str, Any]:
    """End a rejudgement without changing a result; what still waits or runs is cancelled."""
    return _decide(rejudgements.discard, path.rejudgement_id)


def _decide(change: Callable[..., None], rejudgement_id: int) -> dict[str, Any]:
    with services().database.writing() as session:
        _view(session, rejudgement_id)
        _or_conflict(lambda: change(session, access.actor(), rejudgement_id))
        return _answer(_view(session, rejudgement_id))


def _view(session: Session, rejudgement_id: int) -> RejudgementView:
    rejudgement = rejudgements.show(session, rejudgement_id)
    if rejudgement is None:
        raise Problem("not-found", f"There is no rejudgement {rejudgement_id}.")
    return rejudgement


def _answer(rejudgement: RejudgementView) -> dict[str, Any]:
    progress = ("runs", "live", "same", "different", "failed", "part")
    row = [name for name in RejudgementResponse.model_fields if name not in progress]
    shown = {name: getattr(rejudgement.row, name) for name in row}
    return shown | {name: getattr(rejudgement.progress, name) for name in progress}


def _or_conflict(change: Callable[[], Answer]) -> Answer:
    try:
        return change()
    except RejudgementRefused as reason:
        raise Problem("conflict", str(reason)) from None
