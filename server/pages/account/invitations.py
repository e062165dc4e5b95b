"""Invitations to sign up: a teacher makes some for a class and hands them out."""

from flask import Blueprint, g, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.server.accounts import accounts, invitations
from seamark.server.accounts.permissions import Action
from seamark.server.web import access
from seamark.server.web.rate_limits import CREDENTIAL_ATTEMPTS, client, limiter
from seamark.server.web.services import services

page = Blueprint("invitations", __name__)


@page.get("/invitations")
def show() -> ResponseReturnValue:
    """Show how many invitations are unused, and the form for new ones."""
    access.require(Action.INVITE)
    return _page()


@page.post("/invitations")
@limiter.limit(CREDENTIAL_ATTEMPTS, key_func=client)
def create() -> ResponseReturnValue:
    """Make invitations and show their addresses once."""
    user_id = access.require_account(Action.INVITE)
    count = request.form.get("count", 1, type=int)
    days = request.form.get("days", invitations.DAYS, type=int)
    try:
        with services().database.writing() as session:
            texts = invitations.create(
                session,
                days=max(1, min(days, invitations.DAYS_MAX)),
                count=max(1, min(count, invitations.BATCH_MAX)),
                user_id=user_id,
            )
    except accounts.AccountRejected as reason:
        return _page(error=str(reason)), 422
    return _page([url_for("account.sign_up", invitation=text) for text in texts])


def _page(addresses: list[str] | None = None, *, error: str = "") -> str:
    with services().database.reading() as session:
        unused = invitations.open_count(session, g.viewer.user_id)
    host = request.host_url.rstrip("/")
    return render_template(
        "account/invitations.html",
        addresses=[f"{host}{address}" for address in addresses or ()],
        error=error,
        unused=unused,
        days=invitations.DAYS,
        days_max=invitations.DAYS_MAX,
        count_max=invitations.BATCH_MAX,
    )
