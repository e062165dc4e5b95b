"""What the account page does: password, browsers, data, deletion; and the links for resets."""

from flask import (
    Blueprint,
    Response,
    flash,
    g,
    redirect,
    render_template,
    request,
    session,
    url_for,
)
from flask.typing import ResponseReturnValue

from seamark.server.accounts import accounts, browser_sessions, password_resets
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.accounts.audit import AuditAction
from seamark.server.accounts.permissions import Action
from seamark.server.pages.account import account_page
from seamark.server.runs.downloads import export
from seamark.server.runs.ending import account_deletion
from seamark.server.web import access, authentication, reauthentication
from seamark.server.web.problems import Problem
from seamark.server.web.rate_limits import (
    CREDENTIAL_ATTEMPTS,
    EXPORTS,
    GUESSES,
    account,
    client,
    failed,
    limiter,
)
from seamark.server.web.services import services

page = Blueprint("own_account", __name__)


@page.get("/account")
def show() -> ResponseReturnValue:
    """Show the account."""
    access.require(Action.VIEW_ACCOUNT)
    return account_page.render()


@page.post("/password")
@limiter.limit(CREDENTIAL_ATTEMPTS, key_func=client)
@limiter.limit(GUESSES, key_func=account, deduct_when=failed)
def change_password() -> ResponseReturnValue:
    """Change the password, which signs out all other browsers and revokes the tokens."""
    access.require(Action.CHANGE_PASSWORD)
    old, new = request.form.get("old", ""), request.form.get("new", "")
    try:
        with services().database.writing() as database:
            if why := reauthentication.refusal(database, old):
                raise AccountRejected(why)
            user_id = accounts.change_password(database, g.viewer.name, new).id
            access.record(database, AuditAction.PASSWORD_CHANGED, g.viewer.name)
    except AccountRejected as reason:
        return account_page.render(password=str(reason)), 422
    authentication.sign_in(user_id)
    flash("Your password has been changed. Other browsers are signed out, tokens revoked.", "good")
    return redirect(url_for("own_account.show"))


@page.post("/account/browsers/sign-out")
def sign_out_browser() -> ResponseReturnValue:
    """Sign out one of the account's browsers."""
    user_id = access.require_account(Action.CHANGE_PASSWORD)
    with services().database.writing() as database:
        handle = request.form.get("browser", "")
        if not browser_sessions.end_by_handle(database, user_id, handle):
            raise Problem("not-found", "This browser is not signed in.")
    flash("The browser has been signed out.", "good")
    return redirect(url_for("own_account.show"), code=303)


@page.get("/account/data.zip")
@limiter.limit(EXPORTS, key_func=client)
def download() -> ResponseReturnValue:
    """Download all data of the account."""
    access.require(Action.VIEW_ACCOUNT)
    current = services()
    telemetry = request.args.get("telemetry") == "on"
    pieces = export.archive(current.database, current.settings, g.viewer, telemetry=telemetry)
    answer = Response(pieces, content_type="application/zip")
    answer.headers.set("Content-Disposition", "attachment", filename="seamark-account.zip")
    return answer


@page.post("/account/delete")
@limiter.limit(CREDENTIAL_ATTEMPTS, key_func=client)
@limiter.limit(GUESSES, key_func=account, deduct_when=failed)
def delete() -> ResponseReturnValue:
    """Delete the account, after its name and password have been typed to confirm it."""
    user_id = access.require_account(Action.CLOSE_ACCOUNT)
    if request.form.get("confirm", "").strip() != g.viewer.name:
        return account_page.render(delete="Type the name of your account to confirm."), 422
    with services().database.reading() as database:
        why = reauthentication.refusal(database, request.form.get("password", ""))
    if why:
        return account_page.render(delete=why), 422
    kept = request.form.get("published") == "keep"
    with services().database.writing() as database:
        detail = {"keep_published": kept}
        access.record(database, AuditAction.ACCOUNT_DELETED, g.viewer.name, detail)
        account_deletion.close(database, user_id, keep_published=kept)
    session.clear()
    flash("Your account has been deleted.", "good")
    return redirect(url_for("home.show"), code=303)


@page.get("/reset")
def reset() -> ResponseReturnValue:
    """Show the form for a new password of the account in a link."""
    return _reset_form()


@page.post("/reset")
@limiter.limit(CREDENTIAL_ATTEMPTS)
def set_password() -> ResponseReturnValue:
    """Set a new password by a link, which then no longer works."""
    text, new = request.form.get("link", ""), request.form.get("new", "")
    try:
        with services().database.writing() as database:
            user = password_resets.use(database, text, new)
            access.record(database, AuditAction.PASSWORD_CHANGED, user.name)
    except AccountRejected as reason:
        return _reset_form(str(reason)), 422
    authentication.sign_in(user.id)
    flash("Your password has been changed. You are signed in.", "good")
    return redirect(url_for("own_account.show"), code=303)


def _reset_form(error: str = "") -> str:
    return render_template(
        "account/reset.html",
        error=error,
        link=request.values.get("link", ""),
        password_min=accounts.PASSWORD_MIN,
        password_max=accounts.PASSWORD_MAX,
    )
