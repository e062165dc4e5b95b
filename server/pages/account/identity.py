"""Signing in by an identity provider, creating an account by it, linking and unlinking it."""

import re

from flask import Blueprint, flash, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.server.accounts import accounts, audit, identities, invitations
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.accounts.audit import Actor, AuditAction
from seamark.server.accounts.identities import Identity
from seamark.server.accounts.permissions import Action
from seamark.server.pages.account import account, account_page
from seamark.server.web import (
    access,
    authentication,
    client_network,
    identity_provider,
    reauthentication,
)
from seamark.server.web.identity_provider import ProviderAway, SignInRefused, require_provider
from seamark.server.web.rate_limits import (
    CREDENTIAL_ATTEMPTS,
    GUESSES,
    SIGN_INS,
    client,
    failed,
    limiter,
    sign_ups,
)
from seamark.server.web.rate_limits import account as account_key
from seamark.server.web.redirects import leave_for, own_path
from seamark.server.web.services import services

page = Blueprint("identity", __name__)
page.before_request(require_provider)


@page.get("/sign-in/provider")
@limiter.limit(SIGN_INS)
def start() -> ResponseReturnValue:
    """Send the browser to the identity provider; changes nothing here."""
    try:
        return leave_for(identity_provider.start(own_path(request.args.get("next", ""))))
    except ProviderAway:
        return _failed("away"), 503


@page.get(identity_provider.CALLBACK)
@limiter.limit(SIGN_INS)
def callback() -> ResponseReturnValue:
    """Sign in whom the provider has recognised, or ask for a name or a confirmation."""
    try:
        identity, following = identity_provider.finish()
    except ProviderAway:
        return _failed("away"), 503
    except SignInRefused:
        return _failed("refused"), 403
    return _recognised(identity, following)


def _recognised(identity: Identity, following: str) -> ResponseReturnValue:
    with services().database.reading() as database:
        user = identities.find(database, identity)
    if g.viewer.user_id is not None:
        if user is not None and user.id == g.viewer.user_id:
            return redirect(own_path(following))
        identity_provider.keep(identity, following)
        return redirect(url_for("identity.confirm"))
    if user is None:
        identity_provider.keep(identity, following)
        return redirect(url_for("identity.choose_name"))
    if user.disabled_at is not None:
        return _failed("disabled"), 403
    account.flash_adopted(authentication.sign_in(user.id))
    return redirect(own_path(following))


@page.get("/sign-up/provider")
def choose_name() -> ResponseReturnValue:
    """Show the form for the name of a new account."""
    identity = identity_provider.kept()
    if identity is None:
        return redirect(url_for("account.sign_in"))
    return _name_form(identity[0])


@page.post("/sign-up/provider")
@limiter.limit(sign_ups)
def create_account() -> ResponseReturnValue:
    """Create an account for the identity that has just signed in, without a password."""
    pending = identity_provider.kept()
    if pending is None:
        return redirect(url_for("account.sign_in"), code=303)
    (identity, following), mode = pending, services().settings.oidc_sign_up
    if mode == "closed":
        return _name_form(identity), 403
    name = request.form.get("name", "").strip()
    try:
        with services().database.writing() as database:
            if mode == "invitation":
                invitations.accept(database, request.form.get("invitation", ""))
            user_id = accounts.sign_up(database, name, None).id
            identities.link(database, user_id, identity)
            by = Actor(name, client_network.address().removesuffix("/32"))
            audit.record(database, by, AuditAction.IDENTITY_LINKED, name, {"new_account": True})
    except AccountRejected as reason:
        return _name_form(identity, str(reason)), 422
    adopted = authentication.sign_in(user_id)
    flash(f"Welcome, {name}. You can now upload programs and start ranked runs.", "good")
    account.flash_adopted(adopted)
    return redirect(own_path(following), code=303)


@page.get("/account/identity")
def confirm() -> ResponseReturnValue:
    """Ask whether the identity that has just signed in is to be linked to the account.

    Only this question, with a password, links them: else somebody could be led to link the identity
    of an attacker, who would then sign in to their account.
    """
    access.require(Action.CHANGE_PASSWORD)
    identity = identity_provider.kept()
    if identity is None:
        return redirect(url_for("own_account.show"))
    return _link_form(identity[0])


@page.post("/account/identity")
@limiter.limit(CREDENTIAL_ATTEMPTS, key_func=client)
@limiter.limit(GUESSES, key_func=account_key, deduct_when=failed)
def link() -> ResponseReturnValue:
    """Link the identity that has just signed in to the account."""
    user_id = access.require_account(Action.CHANGE_PASSWORD)
    identity = identity_provider.kept()
    if identity is None:
        flash("The sign-in at the identity provider is too long ago. Try again.", "warn")
        return redirect(url_for("own_account.show"), code=303)
    try:
        with services().database.writing() as database:
            if why := reauthentication.refusal(database, request.form.get("password", "")):
                raise AccountRejected(why)
            identities.link(database, user_id, identity[0])
            access.record(database, AuditAction.IDENTITY_LINKED, g.viewer.name)
    except AccountRejected as reason:
        return _link_form(identity[0], str(reason)), 422
    identity_provider.forget()
    flash("You can now sign in with it.", "good")
    return redirect(url_for("own_account.show"), code=303)


@page.post("/account/identity/unlink")
def unlink() -> ResponseReturnValue:
    """Unlink the identity of the provider from the account."""
    user_id = access.require_account(Action.CHANGE_PASSWORD)
    try:
        with services().database.writing() as database:
            if identities.unlink(database, user_id, services().settings.oidc_issuer):
                access.record(database, AuditAction.IDENTITY_UNLINKED, g.viewer.name)
    except AccountRejected as reason:
        return account_page.render(identity=str(reason)), 422
    flash("It is no longer linked to this account.", "good")
    return redirect(url_for("own_account.show"), code=303)


def _failed(why: str) -> str:
    return render_template("account/identity_failed.html", why=why)


def _name_form(identity: Identity, error: str = "") -> str:
    return render_template(
        "account/identity_sign_up.html",
        error=error,
        label=identity.label,
        name=request.form.get("name", "") or _suggested(identity.label),
        mode=services().settings.oidc_sign_up,
        invitation=request.values.get("invitation", ""),
        rule=accounts.NAME_RULE,
        name_max=accounts.NAME_MAX,
    )


def _link_form(identity: Identity, error: str = "") -> str:
    with services().database.reading() as database:
        has_password = accounts.person(database, g.viewer.name).password_hash is not None
    return render_template(
        "account/identity_link.html",
        error=error,
        label=identity.label,
        has_password=has_password,
        password_max=accounts.PASSWORD_MAX,
    )


def _suggested(label: str) -> str:
    """Return a name that an account may have, made from what the provider calls somebody."""
    plain = re.sub(r"[^A-Za-z0-9._-]+", "-", label.partition("@")[0])
    return re.sub(r"^[^A-Za-z]+", "", plain)[: accounts.NAME_MAX].rstrip("-")
