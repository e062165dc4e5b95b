"""The authenticated user and the tokens of the account."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from flask import Response, jsonify, session
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from flask_wtf.csrf import generate_csrf

from seamark.server.accounts import accounts, invitations
from seamark.server.accounts.audit import AuditAction
from seamark.server.accounts.permissions import Action, grantable
from seamark.server.api.classes.class_schemas import ExportQuery
from seamark.server.api.requests import request_body
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import (
    InvitationsRequest,
    InvitationsResponse,
    MeResponse,
    TokenPath,
    TokenRequest,
    TokenResponse,
    TokensResponse,
)
from seamark.server.database.tables import Token
from seamark.server.runs.downloads import export
from seamark.server.runs.submission import quota
from seamark.server.web import access, rate_limits
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

api = APIBlueprint(
    "api_account",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Account", description="The authenticated user and API tokens.")],
)
_ZIP: Any = {200: {"content": {"application/zip": {"schema": {"type": "string"}}}}}


@api.get("/me", responses={200: MeResponse})
def me() -> Response:
    """Return the authenticated user or guest, the scopes of the token and the quota."""
    viewer = access.viewer()
    used: dict[str, int] | None = None
    if viewer.owner is not None:
        with services().database.reading() as database:
            used = asdict(quota.used_by(database, viewer, services().settings))
    response = jsonify(
        {
            "name": viewer.name,
            "user_id": viewer.user_id,
            "role": viewer.role.label,
            "guest": viewer.guest is not None,
            "scopes": sorted(viewer.scopes),
            "quota": used,
            # Other sites cannot read this response, so they cannot obtain the token.
            "csrf_token": generate_csrf() if session else None,
        }
    )
    response.headers["Cache-Control"] = "no-store"
    return response


@api.get("/me/data.zip", responses=_ZIP)
@rate_limits.limiter.limit(rate_limits.EXPORTS, key_func=rate_limits.client)
def data(query: ExportQuery) -> Response:
    """Download all that is stored of your account: runs with configuration, result, program."""
    access.require(Action.VIEW_ACCOUNT)
    current, viewer = services(), access.viewer()
    pieces = export.archive(current.database, current.settings, viewer, telemetry=query.telemetry)
    response = Response(pieces, content_type="application/zip")
    response.headers.set("Content-Disposition", "attachment", filename="seamark-account.zip")
    return response


@api.get("/tokens", responses={200: TokensResponse})
def list_tokens() -> dict[str, Any]:
    """List your tokens, without their texts."""
    user_id = access.require_account(Action.VIEW_ACCOUNT)
    with services().database.reading() as database:
        return {"tokens": [_shown(token) for token in accounts.tokens(database, user_id)]}


@api.post("/tokens", responses={201: TokenResponse})
def create_token() -> Response:
    """Create a token. Its text is only returned in this response."""
    user_id, viewer = access.require_account(Action.MANAGE_TOKENS), access.viewer()
    body = request_body.json_body(TokenRequest)
    missing = set(body.scopes) - set(grantable(viewer))
    if missing:
        raise Problem("scope-missing", f"You cannot grant: {', '.join(sorted(missing))}.")
    try:
        with services().database.writing() as database:
            text = accounts.grant_token(database, viewer, body.name, body.scopes, days=body.days)
            created = _shown(accounts.tokens(database, user_id)[0])
            access.record(database, AuditAction.TOKEN_MADE, viewer.name, {"token": created["id"]})
    except accounts.AccountRejected as reason:
        raise Problem("conflict", str(reason)) from None
    response = jsonify(created | {"token": text})
    response.status_code = 201
    response.headers["Location"] = f"/api/v1/tokens/{created['id']}"
    response.headers["Cache-Control"] = "no-store"
    return response


@api.delete("/tokens/<int:token_id>", responses={204: None})
def delete_token(path: TokenPath) -> Response:
    """Revoke a token; it stops working immediately."""
    user_id = access.require_account(Action.MANAGE_TOKENS)
    with services().database.writing() as database:
        if not accounts.revoke_token(database, user_id, path.token_id):
            raise Problem("not-found", f"You have no token {path.token_id}.")
        name, detail = access.viewer().name, {"token": path.token_id}
        access.record(database, AuditAction.TOKEN_REVOKED, name, detail)
    return Response(status=204)


@api.post("/invitations", responses={201: InvitationsResponse})
def invite() -> Response:
    """Make invitations to sign up, each for one account. Requires the role teacher."""
    user_id = access.require_account(Action.INVITE)
    body = request_body.json_body(InvitationsRequest)
    try:
        with services().database.writing() as database:
            texts = invitations.create(database, days=body.days, count=body.count, user_id=user_id)
    except accounts.AccountRejected as reason:
        raise Problem("conflict", str(reason)) from None
    response = jsonify({"invitations": texts})
    response.status_code = 201
    response.headers["Cache-Control"] = "no-store"
    return response


def _shown(token: Token) -> dict[str, Any]:
    names = ("id", "name", "scopes", "created_at", "expires_at", "last_used_at")
    return {name: getattr(token, name) for name in names}
