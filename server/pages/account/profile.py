"""The public page of a user, and the form of one's own profile."""

from flask import Blueprint, abort, flash, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.server.accounts import profiles
from seamark.server.accounts.permissions import Action
from seamark.server.accounts.profiles import Profile, ProfileRejected
from seamark.server.database.tables import User
from seamark.server.pages.leaderboard.rank_plot import rank_plot
from seamark.server.runs.showing import standings
from seamark.server.web import access, known_benchmarks
from seamark.server.web.known_users import user_of
from seamark.server.web.services import services
from seamark.server.web.url_converters import row_id

page = Blueprint("profile", __name__)


@page.get("/users/<name>")
def show(name: str) -> ResponseReturnValue:
    """Show the profile, the ranks and the published runs of a user."""
    try:
        after = row_id(request.args["after"]) if "after" in request.args else None
    except ValueError:
        abort(404)
    with services().database.reading() as session:
        user = user_of(session, name)
        standing = standings.of_user(session, user.id)
        runs = standings.published(session, user, after=after)
        profile = profiles.of(user)
        shown, own = user.name, user.id == access.viewer().user_id
    return render_template(
        "profile/show.html",
        user=shown,
        own=own,
        profile=profile,
        standings=[
            {
                "benchmark": known_benchmarks.by_name(one.benchmark),
                "rank": one.rank,
                "people": one.people,
                "plot": rank_plot(one.history, one.rank.rank if one.rank else None),
            }
            for one in standing
        ],
        runs=runs.runs,
        next=None if runs.next is None else runs.next.after,
    )


@page.get("/profile")
def edit() -> ResponseReturnValue:
    """Show the form of the viewer's own profile."""
    user_id = access.require_account(Action.VIEW_ACCOUNT)
    with services().database.reading() as session:
        profile = profiles.of(session.get_one(User, user_id))
    return render_template("profile/edit.html", profile=profile, errors={})


@page.post("/profile")
def store() -> ResponseReturnValue:
    """Store the viewer's own profile, or show the form again with what is wrong."""
    user_id = access.require_account(Action.EDIT_PROFILE)
    names = ("public_name", "affiliation", "paper_url", "code_url")
    profile = Profile(**{name: request.form.get(name, "") for name in names})
    try:
        with services().database.writing() as session:
            profiles.store(session, user_id, profile)
    except ProfileRejected as reason:
        return render_template("profile/edit.html", profile=profile, errors=reason.errors), 422
    flash("Your profile is saved.", "good")
    return redirect(url_for("profile.show", name=access.viewer().name), code=303)
