"""Signing up, in and out; API tokens."""

from flask import Blueprint, abort, flash, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue
from flask_limiter import RequestLimit
from sqlalchemy.orm import Session

from seamark.server.accounts import accounts, audit, invitations, profiles
from seamark.server.accounts.audit import AuditAction
from seamark.server.accounts.permissions import Action, grantable
from seamark.server.classes import classrooms
from seamark.server.classes.refusals import ClassRefused
from seamark.server.web import access, authentication, class_access
from seamark.server.web.rate_limits import (
    CREDENTIAL_ATTEMPTS,
    GUESSES,
    SIGN_INS,
    account,
    client,
    failed,
    limiter,
    sign_ups,
    signs_up,
)
from seamark.server.web.redirects import own_path
from seamark.server.web.services import services

_DISABLED = "This account is disabled. Ask the operator of this service."
page = Blueprint("account", __name__)


@page.get("/sign-up")
def sign_up() -> ResponseReturnValue:
    """Show the sign-up form."""
    return _form("account/sign_up.html")


@page.post("/sign-up")
@limiter.limit(sign_ups, key_func=signs_up)
def create_account() -> ResponseReturnValue:
    """Create an account and sign in; with the link to a class, also join it."""
    held = services()
    name, password = request.form.get("name", "").strip(), request.form.get("password", "")
    if held.settings.sign_up == "closed":
        return _form("account/sign_up.html", "Sign-up is closed on this service."), 403
    try:
        with held.database.writing() as session:
            if held.settings.sign_up == "invitation" and not request.form.get("class"):
                invitations.accept(session, request.form.get("invitation", ""))
            user_id = accounts.sign_up(session, name, password).id
            joined = _join_class(session, user_id)
    except (accounts.AccountRejected, ClassRefused) as reason:
        return _form("account/sign_up.html", str(reason)), 422
    adopted = authentication.sign_in(user_id)
    flash(f"Welcome, {name}. You can now upload programs and start ranked runs.", "good")
    flash_adopted(adopted)
    if joined is not None:
        return redirect(url_for("classes.show", class_id=joined))
    return redirect(own_path(request.values.get("next", "")))


def _join_class(session: Session, user_id: int) -> int | None:
    """Join the class of the link that the form was opened with; raises ClassRefused."""
    code = request.form.get("class", "")
    return classrooms.join(session, user_id, code) if code else None


@page.get("/sign-in")
def sign_in() -> ResponseReturnValue:
    """Show the sign-in form."""
    return _form("account/sign_in.html")


def _record_blocked(_limit: RequestLimit) -> None:
    """Write into the audit log that sign-ins are refused after too many failures."""
    actor, database = access.actor(), services().database
    with database.reading() as session:
        user = profiles.find(session, request.form.get("name", "").strip())
        # Not what was typed: it may be a password in the wrong field.
        target = "" if user is None else user.name
        known = audit.blocked_is_known(session, actor, target)
    if not known:
        with database.writing() as session:
            audit.record(session, actor, AuditAction.SIGN_IN_BLOCKED, target)


@page.post("/sign-in")
@limiter.limit(SIGN_INS)
@limiter.limit(CREDENTIAL_ATTEMPTS, deduct_when=failed, on_breach=_record_blocked)
@limiter.limit(GUESSES, key_func=account, deduct_when=failed, on_breach=_record_blocked)
def check_credentials() -> ResponseReturnValue:
    """Sign in; the response is the same for an unknown name and a wrong password."""
    name, password = request.form.get("name", "").strip(), request.form.get("password", "")
    with services().database.reading() as session:
        user = accounts.authenticate(session, name, password)
    if user is None:
        return _form("account/sign_in.html", "Incorrect name or password."), 422
    if user.disabled_at is not None:
        return _form("account/sign_in.html", _DISABLED), 403
    flash_adopted(authentication.sign_in(user.id))
    return redirect(own_path(request.values.get("next", "")))


@page.post("/sign-out")
def sign_out() -> ResponseReturnValue:
    """Sign out."""
    authentication.sign_out()
    return redirect(url_for("home.show"))


@page.get("/tokens")
def tokens() -> ResponseReturnValue:
    """Show the tokens of the account."""
    access.require(Action.VIEW_ACCOUNT)
    return _tokens()


@page.post("/tokens")
@limiter.limit(CREDENTIAL_ATTEMPTS, key_func=client)
def create_token() -> ResponseReturnValue:
    """Create a token and show its text once."""
    access.require(Action.MANAGE_TOKENS)
    days = request.form.get("days", accounts.TOKEN_DAYS, type=int)
    try:
        with services().database.writing() as session:
            text = accounts.grant_token(
                session,
                g.viewer,
                request.form.get("name", ""),
                request.form.getlist("scopes"),
                days=max(1, min(days, accounts.PAGE_TOKEN_DAYS_MAX)),
            )
            made = accounts.tokens(session, g.viewer.user_id)[0]
            _record_token(session, AuditAction.TOKEN_MADE, made.id)
    except accounts.AccountRejected as reason:
        return _tokens(error=str(reason)), 422
    return _tokens(new=text)


@page.post("/tokens/<row:token_id>/revoke")
def revoke_token(token_id: int) -> ResponseReturnValue:
    """Revoke one of the account's tokens."""
    user_id = access.require_account(Action.MANAGE_TOKENS)
    with services().database.writing() as session:
        revoked = accounts.revoke_token(session, user_id, token_id)
        if revoked:
            _record_token(session, AuditAction.TOKEN_REVOKED, token_id)
    if not revoked:
        abort(404)
    flash("The token has been revoked.", "good")
    return redirect(url_for("account.tokens"))


def _record_token(session: Session, action: AuditAction, token_id: int) -> None:
    access.record(session, action, g.viewer.name, {"token": token_id})


def flash_adopted(count: int) -> None:
    """Tell how many runs of a guest the account has now."""
    if count:
        runs = "the run" if count == 1 else f"the {count} runs"
        flash(f"Find {runs} you started without an account under My runs.", "good")


def _form(template: str, error: str = "") -> str:
    return render_template(
        template,
        error=error,
        name=request.form.get("name", ""),
        next=request.values.get("next", ""),
        room=class_access.invited_to(),
        invitation=request.values.get("invitation", ""),
        rule=accounts.NAME_RULE,
        name_max=accounts.NAME_MAX,
        password_min=accounts.PASSWORD_MIN,
        password_max=accounts.PASSWORD_MAX,
    )


def _tokens(*, new: str = "", error: str = "") -> str:
    with services().database.reading() as session:
        tokens = accounts.tokens(session, g.viewer.user_id)
    return render_template(
        "account/tokens.html",
        tokens=tokens,
        token_name_max=accounts.TOKEN_NAME_MAX,
        new=new,
        error=error,
        scopes=grantable(g.viewer),
        days=accounts.TOKEN_DAYS,
        days_max=accounts.PAGE_TOKEN_DAYS_MAX,
    )
