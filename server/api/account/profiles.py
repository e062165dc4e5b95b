"""The public side of users: profile, ranks with their history, published runs."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.accounts import profiles
from seamark.server.accounts.permissions import Action
from seamark.server.accounts.profiles import Profile, ProfileRejected
from seamark.server.api.requests import request_body
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import ProfileBody, UserPath, UserQuery, UserResponse
from seamark.server.runs.showing import standings
from seamark.server.runs.showing.standings import Standing
from seamark.server.web import access
from seamark.server.web.known_users import user_of
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

api = APIBlueprint(
    "api_profiles",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Users", description="Public profiles of users.")],
)


@api.get("/users/<string:name>", responses={200: UserResponse})
def show(path: UserPath, query: UserQuery) -> dict[str, Any]:
    """Return the profile of a user with ranks, their history, and published runs."""
    with services().database.reading() as session:
        user = user_of(session, path.name)
        runs = standings.published(session, user, after=query.after, limit=query.limit)
        return {
            "name": user.name,
            **asdict(profiles.of(user)),
            "ranks": [_standing(one) for one in standings.of_user(session, user.id)],
            "runs": [run.id for run in runs.runs],
            "next": None if runs.next is None else runs.next.after,
        }


@api.put("/me/profile", responses={200: ProfileBody})
def store() -> dict[str, str]:
    """Replace the profile of the account. Links must be http or https addresses."""
    user_id = access.require_account(Action.EDIT_PROFILE)
    body = request_body.json_body(ProfileBody)
    try:
        with services().database.writing() as session:
            return asdict(profiles.store(session, user_id, Profile(**body.model_dump())))
    except ProfileRejected as reason:
        detail = "The profile is not stored."
        raise Problem("invalid-request", detail, errors=reason.errors) from None


def _standing(one: Standing) -> dict[str, Any]:
    rank = one.rank
    return {
        "benchmark": one.benchmark,
        "rank": rank.rank if rank else None,
        "rank_low": rank.rank_low if rank else None,
        "rank_high": rank.rank_high if rank else None,
        "people": one.people,
        "score": rank.score if rank else None,
        "run": rank.run_id if rank else None,
        "history": [
            {"at": point.at, "rank": point.rank, "people": point.people, "score": point.score}
            for point in one.history
        ],
    }
