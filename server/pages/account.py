"""Accounts: sign up, in and out, and the tokens of programs."""

from urllib.parse import urlsplit

from flask import Blueprint, abort, flash, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import ADMIN, SCOPES, Action, can
from seamark.server.web import authentication
from seamark.server.web.rate_limits import SIGN_IN, SIGN_INS, limiter, refused, sign_ups, who
from seamark.server.web.services import services

TOKEN_DAYS_MAX = 365
page = Blueprint("account", __name__)


@page.get("/sign-up")
def sign_up() -> ResponseReturnValue:
    """Show the form of a new account."""
    return _form("account/sign_up.html")


@page.post("/sign-up")
@limiter.limit(sign_ups)
def make_account() -> ResponseReturnValue:
    """Make an account and sign it in."""
    held = services()
    name, password = request.form.get("name", "").strip(), request.form.get("password", "")
    if not held.settings.sign_up_open:
        return _form("account/sign_up.html", "This service does not take new accounts."), 403
    try:
        with held.database.writing() as session:
            user_id = accounts.sign_up(session, name, password).id
    except accounts.AccountRejected as refusal:
        return _form("account/sign_up.html", str(refusal)), 422
    adopted = authentication.sign_in(user_id)
    flash(f"Welcome, {name}. You can upload programs and make ranked runs now.", "good")
    _say_adopted(adopted)
    return redirect(_next())


@page.get("/sign-in")
def sign_in() -> ResponseReturnValue:
    """Show the form for name and password."""
    return _form("account/sign_in.html")


@page.post("/sign-in")
@limiter.limit(SIGN_INS)
@limiter.limit(SIGN_IN, deduct_when=refused)
def enter() -> ResponseReturnValue:
    """Sign in, with the same answer for a wrong name and a wrong password."""
    name, password = request.form.get("name", "").strip(), request.form.get("password", "")
    with services().database.reading() as session:
        user = accounts.authenticate(session, name, password)
    if user is None:
        return _form("account/sign_in.html", "Name and password do not belong together."), 422
    _say_adopted(authentication.sign_in(user.id))
    return redirect(_next())


@page.post("/sign-out")
def sign_out() -> ResponseReturnValue:
    """Sign out."""
    authentication.sign_out()
    return redirect(url_for("home.show"))


@page.get("/tokens")
def tokens() -> ResponseReturnValue:
    """Show the viewer's tokens."""
    if not can(g.viewer, Action.MANAGE_ACCOUNT):
        return redirect(url_for("account.sign_in", next=request.path))
    return _tokens()


@page.post("/tokens")
@limiter.limit(SIGN_IN, key_func=who)
def make_token() -> ResponseReturnValue:
    """Make a token and show it, this once."""
    if not can(g.viewer, Action.MANAGE_ACCOUNT):
        abort(404)
    days = request.form.get("days", accounts.TOKEN_DAYS, type=int)
    scopes = [scope for scope in request.form.getlist("scopes") if scope in _grantable()]
    try:
        with services().database.writing() as session:
            text = accounts.new_token(
                session,
                g.viewer.user_id,
                request.form.get("name", ""),
                scopes,
                days=max(1, min(days, TOKEN_DAYS_MAX)),
            )
    except accounts.AccountRejected as refusal:
        return _tokens(error=str(refusal)), 422
    return _tokens(new=text)


@page.post("/password")
@limiter.limit(SIGN_IN, key_func=who)
def change_password() -> ResponseReturnValue:
    """Change the viewer's password; other browsers that are signed in are out."""
    if not can(g.viewer, Action.MANAGE_ACCOUNT):
        abort(404)
    old, new = request.form.get("old", ""), request.form.get("new", "")
    try:
        with services().database.writing() as session:
            user_id = accounts.change_password(session, g.viewer.name, old, new).id
    except accounts.AccountRejected as refusal:
        return _tokens(password_error=str(refusal)), 422
    authentication.sign_in(user_id)
    flash("The password is changed; other browsers have to sign in again.", "good")
    return redirect(url_for("account.tokens"))


@page.post("/tokens/<row:token_id>/revoke")
def revoke_token(token_id: int) -> ResponseReturnValue:
    """Delete one of the viewer's tokens."""
    if not can(g.viewer, Action.MANAGE_ACCOUNT):
        abort(404)
    with services().database.writing() as session:
        gone = accounts.revoke_token(session, g.viewer.user_id, token_id)
    if not gone:
        abort(404)
    flash("The token is withdrawn; programs that use it are refused from now on.", "good")
    return redirect(url_for("account.tokens"))


def _say_adopted(count: int) -> None:
    if count:
        what = "The run that you made" if count == 1 else f"The {count} runs that you made"
        flash(f"{what} without an account can be found under My runs.", "good")


def _grantable() -> list[str]:
    return [scope for scope in SCOPES if scope != ADMIN or g.viewer.is_admin]


def _form(template: str, error: str = "") -> str:
    return render_template(
        template,
        error=error,
        name=request.form.get("name", ""),
        next=request.values.get("next", ""),
        rule=accounts.NAME_RULE,
        password_min=accounts.PASSWORD_MIN,
        password_max=accounts.PASSWORD_MAX,
    )


def _tokens(*, new: str = "", error: str = "", password_error: str = "") -> str:
    with services().database.reading() as session:
        kept = accounts.tokens(session, g.viewer.user_id)
    return render_template(
        "account/tokens.html",
        tokens=kept,
        new=new,
        error=error,
        password_error=password_error,
        password_min=accounts.PASSWORD_MIN,
        password_max=accounts.PASSWORD_MAX,
        scopes=_grantable(),
        days=accounts.TOKEN_DAYS,
        days_max=TOKEN_DAYS_MAX,
    )


def _next() -> str:
    """Return where to go on: an address of this site, never one of another."""
    wanted = request.values.get("next", "").replace("\\", "/")
    parts = urlsplit(wanted)
    inside = wanted.startswith("/") and not wanted.startswith("//")
    return wanted if inside and not parts.netloc else url_for("home.show")
