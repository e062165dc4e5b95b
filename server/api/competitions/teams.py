"""Teams of a competition and what they submitted."""

from __future__ import annotations

from typing import Any

from flask import Response, g, jsonify, url_for
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.accounts.permissions import Action
from seamark.server.api.competitions.competition_schemas import (
    CompetitionPath,
    EntriesResponse,
    EntryPath,
    EntryResponse,
    MemberPath,
    TeamChange,
    TeamJoinRequest,
    TeamRequest,
    TeamResponse,
)
from seamark.server.api.requests import refusals, request_body
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.competitions import teams
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.competitions.teams import TeamView
from seamark.server.judging import entries
from seamark.server.judging.entries import EntryView
from seamark.server.web import access, competition_access, rate_limits
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.server.web.site_address import site_address

api = APIBlueprint(
    "api_teams",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Competitions", description="Competitions, their teams and boards.")],
)


@api.post("/competitions/<string:name>/teams", responses={201: TeamResponse})
@rate_limits.limiter.limit(rate_limits.SUBMISSIONS, key_func=rate_limits.client)
def found_team(path: CompetitionPath) -> Response:
    """Found a team, whose captain you are, and agree on the rules."""
    user_id = access.require_account(Action.COMPETE)
    competition = competition_access.shown(path.name)
    body = request_body.json_body(TeamRequest)
    with refusals.as_problems(), services().database.writing() as database:
        teams.found(database, competition, user_id, body.name)
    answer = jsonify(_own(competition))
    answer.status_code = 201
    answer.headers["Location"] = f"/api/v1/competitions/{competition.name}/team"
    return answer


@api.post("/competitions/<string:name>/teams/join", responses={200: TeamResponse})
@rate_limits.limiter.limit(rate_limits.SUBMISSIONS, key_func=rate_limits.client)
@rate_limits.limiter.limit(
    rate_limits.CODES, key_func=rate_limits.client, deduct_when=rate_limits.failed
)
@rate_limits.limiter.limit(rate_limits.CODES_OF_ADDRESS, deduct_when=rate_limits.failed)
def join_team(path: CompetitionPath) -> dict[str, Any]:
    """Join the team with a code, and agree on the rules. Joining it again changes nothing."""
    user_id = access.require_account(Action.COMPETE)
    competition = competition_access.shown(path.name)
    body = request_body.json_body(TeamJoinRequest)
    with refusals.as_problems(), services().database.writing() as database:
        teams.join(database, competition, user_id, body.code)
    return _own(competition)


@api.get("/competitions/<string:name>/team", responses={200: TeamResponse})
def show_team(path: CompetitionPath) -> dict[str, Any]:
    """Show your team in a competition, with its code."""
    return _answer(*competition_access.member_of(path.name, Action.VIEW_ACCOUNT))


@api.patch("/competitions/<string:name>/team", responses={200: TeamResponse})
def change_team(path: CompetitionPath) -> dict[str, Any]:
    """Change the team whose captain you are: name, captain, code."""
    competition, team = competition_access.captain_of(path.name)
    body = request_body.json_body(TeamChange)
    with refusals.as_problems(), services().database.writing() as database:
        teams.change(
            database, team, name=body.name, captain_id=body.captain, new_code=body.new_code
        )
    return _own(competition)


@api.delete("/competitions/<string:name>/team/members/<int:user_id>", responses={204: None})
def remove_member(path: MemberPath) -> Response:
    """Leave your team; its captain can also remove another member. Entries stay the team's."""
    own = path.user_id == g.viewer.user_id
    within = competition_access.member_of if own else competition_access.captain_of
    _, team = within(path.name)
    if not team.has(path.user_id):
        raise Problem("not-found", f"The team has no member {path.user_id}.")
    with services().database.writing() as database:
        teams.leave(database, team, path.user_id)
    return Response(status=204)


@api.get("/competitions/<string:name>/entries", responses={200: EntriesResponse})
def list_entries(path: CompetitionPath) -> dict[str, Any]:
    """List what your team submitted, newest first; what is in a final is not among it."""
    return _entries(*competition_access.member_of(path.name, Action.VIEW_ACCOUNT))


@api.post(
    "/competitions/<string:name>/entries/<int:run_id>/withdraw", responses={200: EntriesResponse}
)
def withdraw_entry(path: EntryPath) -> dict[str, Any]:
    """Take an entry out of the competition for good. It still counts for the quota."""
    competition, team = competition_access.captain_of(path.name)
    with refusals.as_problems(), services().database.writing() as database:
        entries.withdraw(database, competition, team, path.run_id)
    return _entries(competition, team)


@api.put(
    "/competitions/<string:name>/entries/<int:run_id>/choice", responses={200: EntriesResponse}
)
def choose_entry(path: EntryPath) -> dict[str, Any]:
    """Choose an entry of the qualification for the final, in place of one of the same method."""
    return _choose(path, chosen=True)


@api.delete(
    "/competitions/<string:name>/entries/<int:run_id>/choice", responses={200: EntriesResponse}
)
def unchoose_entry(path: EntryPath) -> dict[str, Any]:
    """Take back that an entry is chosen for the final."""
    return _choose(path, chosen=False)


def _choose(path: EntryPath, *, chosen: bool) -> dict[str, Any]:
    competition, team = competition_access.captain_of(path.name)
    with refusals.as_problems(), services().database.writing() as database:
        entries.choose(database, competition, team, path.run_id, chosen=chosen)
    return _entries(competition, team)


def _own(competition: CompetitionView) -> dict[str, Any]:
    """Return the team of who has just joined or changed it, whatever the token's scopes."""
    team = competition_access.own_team(competition)
    if team is None:
        raise Problem("not-found")
    return _answer(competition, team)


def _answer(competition: CompetitionView, team: TeamView) -> dict[str, Any]:
    path = url_for("competition_teams.invitation", name=competition.name, code=team.code)
    return {
        "id": team.id,
        "competition": competition.name,
        "name": team.name,
        "code": team.code,
        "join_url": f"{site_address()}{path}",
        "members": [
            {
                "user_id": member.user_id,
                "name": member.name,
                "joined_at": member.joined_at,
                "captain": member.user_id == team.captain_id,
            }
            for member in team.members
        ],
    }


def _entries(competition: CompetitionView, team: TeamView) -> dict[str, Any]:
    with services().database.reading() as database:
        own = entries.own(database, competition, team.id)
    current = competition.current
    left = None if current is None else max(entries.left(own, current), 0)
    return {"entries": [_entry(each) for each in own], "left": left}


def _entry(view: EntryView) -> dict[str, Any]:
    same = EntryResponse.model_fields.keys() - {"run", "state"}
    values = {name: getattr(view, name) for name in same}
    return values | {"run": view.run_id, "state": view.state.value}
