"""E-mail: the address of an account and its confirmation, notices, and forgotten passwords."""

from flask import Blueprint, flash, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.server.accounts import password_resets
from seamark.server.accounts.audit import AuditAction
from seamark.server.accounts.permissions import Action
from seamark.server.mail import addresses
from seamark.server.mail.addresses import MailRejected
from seamark.server.pages.account import account_page
from seamark.server.web import access, reauthentication
from seamark.server.web.outgoing_mail import require_mail
from seamark.server.web.rate_limits import (
    CREDENTIAL_ATTEMPTS,
    GUESSES,
    account,
    client,
    failed,
    limiter,
)
from seamark.server.web.services import services

page = Blueprint("mail", __name__)
page.before_request(require_mail)


@page.get("/forgot")
def forgot() -> ResponseReturnValue:
    """Show the form for an e-mail with a link for a new password."""
    return _forgot_form()


@page.post("/forgot")
@limiter.limit(CREDENTIAL_ATTEMPTS)
def send_reset() -> ResponseReturnValue:
    """Have a link sent; the answer and its time are the same for every address."""
    try:
        with services().database.writing() as database:
            addresses.request_reset(database, request.form.get("address", ""))
    except MailRejected as reason:
        return _forgot_form(error=str(reason)), 422
    return _forgot_form(sent=True)


@page.post("/account/mail")
@limiter.limit(CREDENTIAL_ATTEMPTS, key_func=client)
@limiter.limit(GUESSES, key_func=account, deduct_when=failed)
def propose() -> ResponseReturnValue:
    """Have a link sent to a new address; needs the password, which it can later replace."""
    user_id = access.require_account(Action.CHANGE_PASSWORD)
    with services().database.reading() as database:
        why = reauthentication.refusal(database, request.form.get("password", ""))
    if why:
        return account_page.render(mail=why), 422
    try:
        with services().database.writing() as database:
            addresses.propose(database, user_id, request.form.get("address", ""))
    except MailRejected as reason:
        return account_page.render(mail=str(reason)), 422
    flash("A link has been sent. Open it to confirm the address.", "good")
    return redirect(url_for("own_account.show"), code=303)


@page.post("/account/mail/remove")
def remove() -> ResponseReturnValue:
    """Remove the address of the account."""
    user_id = access.require_account(Action.CHANGE_PASSWORD)
    with services().database.writing() as database:
        addresses.remove(database, user_id)
        access.record(database, AuditAction.MAIL_ADDRESS_REMOVED, g.viewer.name)
    flash("The e-mail address has been removed.", "good")
    return redirect(url_for("own_account.show"), code=303)


@page.post("/account/mail/notify")
def notify() -> ResponseReturnValue:
    """Ask for e-mails about runs that have ended, or for none."""
    user_id = access.require_account(Action.EDIT_PROFILE)
    minutes = request.form.get("minutes", None, type=int)
    try:
        with services().database.writing() as database:
            addresses.set_notification(database, user_id, minutes)
    except MailRejected as reason:
        return account_page.render(mail=str(reason)), 422
    flash("Your choice is saved.", "good")
    return redirect(url_for("own_account.show"), code=303)


@page.get("/mail/confirm")
def show_confirmation() -> ResponseReturnValue:
    """Show a button; programs that look at the links of e-mails must not confirm anything."""
    return _confirm_form()


@page.post("/mail/confirm")
@limiter.limit(CREDENTIAL_ATTEMPTS)
def confirm() -> ResponseReturnValue:
    """Confirm an address by a link, which then no longer works."""
    try:
        with services().database.writing() as database:
            user = addresses.confirm(database, request.form.get("link", ""))
            access.record(database, AuditAction.MAIL_ADDRESS_CHANGED, user.name)
            name = user.name
    except MailRejected as reason:
        return _confirm_form(error=str(reason)), 422
    flash(f"The e-mail address of the account {name} is confirmed.", "good")
    own = g.viewer.name == name
    return redirect(url_for("own_account.show" if own else "account.sign_in"), code=303)


def _forgot_form(*, error: str = "", sent: bool = False) -> str:
    return render_template(
        "account/forgot.html",
        error=error,
        sent=sent,
        address=request.form.get("address", ""),
        address_max=addresses.ADDRESS_MAX,
        hours=password_resets.HOURS,
    )


def _confirm_form(*, error: str = "") -> str:
    link = request.values.get("link", "")
    return render_template("account/confirm_mail.html", error=error, link=link)
