"""Who asks, and the tokens of one's account."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from flask import Response, jsonify, session
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from flask_wtf.csrf import generate_csrf

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import READ, SUBMIT, Action, can
from seamark.server.api import authorization, request_body
from seamark.server.api.schemas import (
    MeResponse,
    TokenPath,
    TokenRequest,
    TokenResponse,
    TokensResponse,
)
from seamark.server.database.tables import Token
from seamark.server.runs import quota
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

TOKENS_MAX = 50  # per account

api = APIBlueprint(
    "api_account",
    __name__,
    url_prefix="/api/v1",
    abp_tags=[Tag(name="Account", description="Who asks; tokens for programs.")],
)


@api.get("/me", responses={200: MeResponse})
def me() -> Response:
    """Show who asks, what the token may do and what is left of the quotas."""
    asking = authorization.viewer()
    used: dict[str, int] | None = None
    if asking.owner is not None:
        with services().database.reading() as database:
            used = asdict(quota.used_by(database, asking, services().settings))
    answer = jsonify(
        {
            "name": asking.name,
            "user_id": asking.user_id,
            "is_admin": asking.is_admin,
            "guest": asking.guest is not None,
            "scopes": sorted(asking.scopes),
            "quota": used,
            # Other sites cannot read this answer, so it is a good place for the secret.
            "csrf_token": generate_csrf() if session else None,
        }
    )
    answer.headers["Cache-Control"] = "no-store"
    return answer


@api.get("/tokens", responses={200: TokensResponse})
def list_tokens() -> dict[str, Any]:
    """List one's tokens; their texts are not kept."""
    user_id = authorization.require_account()
    authorization.require_scope(READ)
    with services().database.reading() as database:
        return {"tokens": [_shown(token) for token in accounts.tokens(database, user_id)]}


@api.post("/tokens", responses={201: TokenResponse})
def create_token() -> Response:
    """Make a token. Its text is in this answer and can never be shown again."""
    user_id = authorization.require_account()
    _need_account_rights()
    order = request_body.json_body(TokenRequest)
    missing = set(order.scopes) - authorization.viewer().scopes
    if missing:
        raise Problem("scope-missing", f"A token cannot give away {', '.join(sorted(missing))}.")
    with services().database.writing() as database:
        if len(accounts.tokens(database, user_id)) >= TOKENS_MAX:
            raise Problem("conflict", f"There are {TOKENS_MAX} tokens already; delete one first.")
        text = accounts.new_token(database, user_id, order.name, order.scopes, days=order.days)
        made = _shown(accounts.tokens(database, user_id)[0])
    answer = jsonify(made | {"token": text})
    answer.status_code = 201
    answer.headers["Location"] = f"/api/v1/tokens/{made['id']}"
    answer.headers["Cache-Control"] = "no-store"
    return answer


@api.delete("/tokens/<int:token_id>", responses={204: None})
def delete_token(path: TokenPath) -> Response:
    """Delete a token; it stops working at once."""
    user_id = authorization.require_account()
    _need_account_rights()
    with services().database.writing() as database:
        if not accounts.revoke_token(database, user_id, path.token_id):
            raise Problem("not-found", f"There is no token {path.token_id} of yours.")
    return Response(status=204)


def _need_account_rights() -> None:
    if not can(authorization.viewer(), Action.MANAGE_ACCOUNT):
        raise Problem("scope-missing", f"This call needs the scope {SUBMIT}.")


def _shown(token: Token) -> dict[str, Any]:
    names = ("id", "name", "scopes", "created_at", "expires_at", "last_used_at")
    return {name: getattr(token, name) for name in names}
