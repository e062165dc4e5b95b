"""The accounts of people, for admins."""

from collections.abc import Mapping

from flask import flash, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from seamark.server.accounts import password_resets
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.accounts.permissions import ACCOUNT_ROLES, Role
from seamark.server.administration import people
from seamark.server.administration.people import PersonFilter
from seamark.server.database.tables import User
from seamark.server.pages.administration.admin_page import admin_page
from seamark.server.web import access
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.server.web.site_address import site_address

ADMIN_PAGE = admin_page("people", __name__, label="Users", path="/users", view="listed")
page = ADMIN_PAGE.blueprint
_ROLES = {role.label: role for role in ACCOUNT_ROLES}


@page.get("")
def listed() -> ResponseReturnValue:
    """List the accounts, filtered."""
    wanted = PersonFilter(
        text=request.args.get("q", "").strip()[: people.SEARCH_MAX],
        role=_ROLES.get(request.args.get("role", "")),
        disabled=request.args.get("disabled") == "on",
    )
    after = request.args.get("after", type=int)
    with services().database.reading() as session:
        accounts = people.page(session, wanted, after=after)
    kept = {
        name: request.args[name] for name in ("q", "role", "disabled") if request.args.get(name)
    }
    return render_template(
        "admin/users.html",
        accounts=accounts,
        wanted=wanted,
        kept=kept,
        first=after is None,
        roles=_ROLES,
        search_max=people.SEARCH_MAX,
    )


@page.get("/<row:user_id>")
def show(user_id: int) -> ResponseReturnValue:
    """Show an account."""
    return _page(user_id)


@page.post("/<row:user_id>")
def change(user_id: int) -> ResponseReturnValue:
    """Change the role and the quota of an account."""
    number = request.form.get("quota_day", "").strip()
    if number and not (number.isascii() and number.isdecimal() and len(number) < 10):
        return _page(user_id, error="Runs in 24 hours: a whole number, or nothing."), 422
    wanted = {"quota_day": int(number) if number else None}
    role = request.form.get("role", "")
    with services().database.reading() as session:
        before = _user(session, user_id).role
    changes = wanted | ({"role": role} if role in _ROLES and role != before else {})
    return _apply(user_id, changes, "The account has been changed.")


@page.post("/<row:user_id>/disable")
def disable(user_id: int) -> ResponseReturnValue:
    """Refuse an account everywhere."""
    done = "The account is disabled: it cannot sign in, and its runs are cancelled."
    return _apply(user_id, {"disabled": True}, done)


@page.post("/<row:user_id>/enable")
def enable(user_id: int) -> ResponseReturnValue:
    """Let a disabled account sign in again."""
    return _apply(user_id, {"disabled": False}, "The account can be used again.")


@page.post("/<row:user_id>/revoke")
def revoke(user_id: int) -> ResponseReturnValue:
    """Sign out all browsers of an account and revoke all its tokens."""
    with services().database.writing() as session:
        people.revoke_access(session, access.actor(), _user(session, user_id))
    return _back(user_id, "All browsers are signed out and all tokens revoked.")


@page.post("/<row:user_id>/reset")
def reset(user_id: int) -> ResponseReturnValue:
    """Make a link for a new password and show it once."""
    try:
        with services().database.writing() as session:
            text = people.make_reset_link(session, access.actor(), _user(session, user_id))
    except AccountRejected as reason:
        return _page(user_id, error=str(reason)), 422
    return _page(user_id, link=site_address() + url_for("own_account.reset", link=text))


@page.post("/<row:user_id>/delete")
def delete(user_id: int) -> ResponseReturnValue:
    """Delete an account, after its name has been typed."""
    kept = request.form.get("published") == "keep"
    try:
        with services().database.writing() as session:
            user = _user(session, user_id)
            name = user.name
            if request.form.get("confirm", "").strip() != name:
                raise AccountRejected("Type the name of the account to confirm.")
            people.close(session, access.actor(), user, keep_published=kept)
    except AccountRejected as reason:
        return _page(user_id, delete_error=str(reason)), 422
    flash(f"The account {name} has been deleted. The workers delete its runs.", "good")
    return redirect(url_for("people.listed"), code=303)


def _apply(user_id: int, changes: Mapping[str, object], done: str) -> ResponseReturnValue:
    try:
        with services().database.writing() as session:
            people.apply(session, access.actor(), _user(session, user_id), changes)
    except AccountRejected as reason:
        return _page(user_id, error=str(reason)), 422
    return _back(user_id, done)


def _back(user_id: int, done: str) -> ResponseReturnValue:
    flash(done, "good")
    return redirect(url_for("people.show", user_id=user_id), code=303)


def _user(session: Session, user_id: int) -> User:
    user = people.find(session, user_id)
    if user is None:
        raise Problem("not-found", f"There is no account {user_id}.")
    return user


def _page(user_id: int, *, error: str = "", delete_error: str = "", link: str = "") -> str:
    held = services()
    with held.database.reading() as session:
        person = people.detail(session, _user(session, user_id), held.settings)
    return render_template(
        "admin/user.html",
        person=person,
        user=person.user,
        roles=_ROLES,
        role=Role[person.user.role.upper()],
        own=person.user.id == access.viewer().user_id,
        quota_day=held.settings.quota_day,
        quota_max=people.QUOTA_DAY_MAX,
        hours=password_resets.HOURS,
        error=error,
        delete_error=delete_error,
        link=link,
    )
