"""Boards of rounds as JSON and as CSV."""

from __future__ import annotations

from typing import Any

from flask import Response, jsonify, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.competitions.document import RoundKind
from seamark.server.accounts.permissions import Action
from seamark.server.api.competitions.competition_schemas import (
    BoardQuery,
    BoardResponse,
    BoardRowResponse,
    RoundPath,
)
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.judging import boards
from seamark.server.judging.boards import BoardRow
from seamark.server.web import access, competition_access, csv_export
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

api = APIBlueprint(
    "api_boards",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Competitions", description="Competitions, their teams and boards.")],
)


@api.get("/competitions/<string:name>/rounds/<int:number>/board", responses={200: BoardResponse})
def show_board(path: RoundPath, query: BoardQuery) -> Response:
    """Return the board of a round as JSON or CSV; of a hidden one the rows of your team.

    These have no places then, which would tell about the others. Nobody sees a final before it is
    decided.
    """
    access.require(Action.LIST)
    competition = competition_access.shown(path.name)
    if path.number > len(competition.rounds):
        raise Problem("not-found", f"{competition.name} has no round {path.number}.")
    one, team = competition.rounds[path.number - 1], competition_access.own_team(competition)
    with services().database.reading() as session:
        board = boards.board(session, competition, one, by_method=query.per == "method")
    seen = competition_access.sees_board(competition, path.number)
    team_id = None if team is None else team.id
    rows = [_row(row, team_id=team_id) for row in board.rows]
    if not seen:
        sealed = one.kind is RoundKind.FINAL
        rows = [_without_place(row) for row in rows if row["own"] and not sealed]
    marks = [_row(row, team_id=None) for row in board.references]
    if _wants_csv(query):
        lines = csv_export.lines(list(BoardRowResponse.model_fields), [*rows, *marks])
        answer = Response(lines, content_type=csv_export.MEDIA_TYPE)
    else:
        answer = jsonify(
            competition=competition.name,
            round=one.number,
            per=query.per,
            hidden=not seen,
            decided=one.decided_at is not None,
            rows=rows,
            reference_entries=marks,
        )
    answer.headers["Vary"] = "Accept"
    return answer


def _row(row: BoardRow, *, team_id: int | None) -> dict[str, Any]:
    same = (
        *("place", "place_low", "place_high", "team", "method", "score"),
        *("submitted_at", "submissions", "refusal"),
    )
    return {name: getattr(row, name) for name in same} | {
        "run": row.run_id,
        "score_low": row.low,
        "score_high": row.high,
        "own": team_id is not None and row.team_id == team_id,
    }


def _without_place(row: dict[str, Any]) -> dict[str, Any]:
    return row | dict.fromkeys(("place", "place_low", "place_high"))


def _wants_csv(query: BoardQuery) -> bool:
    if query.format is not None:
        return query.format == "csv"
    return request.accept_mimetypes.best_match(["application/json", "text/csv"]) == "text/csv"
