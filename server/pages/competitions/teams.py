"""Teams: founded or joined by a link, changed by their captain, with what they submitted."""

from collections.abc import Callable
from functools import partial

from flask import Blueprint, flash, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from seamark.competitions.document import Carry
from seamark.server.accounts.permissions import Action
from seamark.server.competitions import teams
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.competitions.teams import TeamView
from seamark.server.judging import entries, methods
from seamark.server.pages.competitions import competitions, wording
from seamark.server.web import access, competition_access
from seamark.server.web.problems import Problem
from seamark.server.web.rate_limits import (
    CODES,
    CODES_OF_ADDRESS,
    SUBMISSIONS,
    client,
    failed,
    limiter,
)
from seamark.server.web.services import services
from seamark.server.web.site_address import site_address

ENTRIES_SHOWN = 200  # what is cancelled before it starts counts for no quota
AGREED = "agreed"  # the checkbox of whoever founds or joins a team
_NOT_AGREED = "Read the rules and tick the box: all members of a team agree on them."
page = Blueprint("competition_teams", __name__, url_prefix="/competitions/<name>")


@page.post("/teams")
@limiter.limit(SUBMISSIONS, key_func=client)
def found(name: str) -> ResponseReturnValue:
    """Make a team whose captain is the viewer."""
    user_id = access.require_account(Action.COMPETE)
    competition = competition_access.shown(name)
    try:
        _require_agreed()
        with services().database.writing() as session:
            teams.found(session, competition, user_id, request.form.get("team", ""))
    except CompetitionRefused as refusal:
        errors = {refusal.field: str(refusal)}
        return competitions.shown(competition, errors, request.form), 422
    flash("Your team takes part. Send its link to whom you want to join it.", "good")
    return _team(name)


@page.get("/join/<code>")
@limiter.limit(CODES_OF_ADDRESS, deduct_when=failed)
def invitation(name: str, code: str) -> ResponseReturnValue:
    """Show to whoever has the link of a team how to join it."""
    competition, team = _invited(name, code)
    if team.has(g.viewer.user_id):
        return _team(name)
    return _invitation(competition, team, {})


@page.post("/join")
@limiter.limit(SUBMISSIONS, key_func=client)
@limiter.limit(CODES, key_func=client, deduct_when=failed)
@limiter.limit(CODES_OF_ADDRESS, deduct_when=failed)
def join(name: str) -> ResponseReturnValue:
    """Join the team with a code."""
    user_id = access.require_account(Action.COMPETE)
    code = request.form.get("code", "")
    competition, team = _invited(name, code)
    try:
        _require_agreed()
        with services().database.writing() as session:
            teams.join(session, competition, user_id, code)
    except CompetitionRefused as refusal:
        return _invitation(competition, team, {refusal.field: str(refusal)}), 422
    flash("You have joined the team.", "good")
    return _team(name)


@page.get("/team")
def show(name: str) -> ResponseReturnValue:
    """Show the viewer's team: members, link and entries."""
    return _shown(*competition_access.member_of(name, Action.VIEW_ACCOUNT))


@page.post("/team")
def rename(name: str) -> ResponseReturnValue:
    """Give the team another name."""
    competition, team = competition_access.captain_of(name)
    try:
        with services().database.writing() as session:
            teams.change(session, team, name=request.form.get("team", ""))
    except CompetitionRefused as refusal:
        return _shown(competition, team, {refusal.field: str(refusal)}), 422
    flash("The team has its new name.", "good")
    return _team(name)


@page.post("/team/link")
def renew_link(name: str) -> ResponseReturnValue:
    """Replace the link of the team."""
    _, team = competition_access.captain_of(name)
    with services().database.writing() as session:
        teams.change(session, team, new_code=True)
    flash("The team has a new link. Nobody can join with the old one.", "good")
    return _team(name)


@page.post("/team/leave")
def leave(name: str) -> ResponseReturnValue:
    """Leave the team."""
    _, team = competition_access.member_of(name)
    with services().database.writing() as session:
        teams.leave(session, team, access.require_account(Action.COMPETE))
    flash(f"You have left the team {team.name}. What you submitted stays the team's.", "good")
    return redirect(url_for("competitions.show", name=name), code=303)


@page.post("/team/members/<row:user_id>/remove")
def remove(name: str, user_id: int) -> ResponseReturnValue:
    """Remove another member."""
    _, team = competition_access.captain_of(name)
    if not team.has(user_id) or user_id == g.viewer.user_id:
        raise Problem("not-found", "The team has no other member with this number.")
    with services().database.writing() as session:
        teams.leave(session, team, user_id)
    flash("The member has been removed. Press “New link” to keep them from joining again.", "good")
    return _team(name)


@page.post("/team/members/<row:user_id>/captain")
def hand_over(name: str, user_id: int) -> ResponseReturnValue:
    """Make another member the captain."""
    _, team = competition_access.captain_of(name)
    try:
        with services().database.writing() as session:
            teams.change(session, team, captain_id=user_id)
    except CompetitionRefused as refusal:
        raise Problem("not-found", str(refusal)) from None
    flash("The team has another captain.", "good")
    return _team(name)


@page.post("/team/entries/<row:run_id>/withdraw")
def withdraw(name: str, run_id: int) -> ResponseReturnValue:
    """Take an entry out of the competition."""
    return _change_entry(name, partial(entries.withdraw, run_id=run_id), "no longer counts")


@page.post("/team/methods")
def describe(name: str) -> ResponseReturnValue:
    """Describe a method of the viewer's team."""
    _, team = competition_access.member_of(name)
    method, text = request.form.get("method", ""), request.form.get("text", "")
    try:
        with services().database.writing() as session:
            methods.describe(session, team, method, text.replace("\r\n", "\n"))
    except CompetitionRefused as refusal:
        flash(str(refusal), "bad")
    else:
        flash("The description is saved.", "good")
    return _team(name)


@page.post("/team/entries/<row:run_id>/choose")
def choose(name: str, run_id: int) -> ResponseReturnValue:
    """Take an entry into the final, or out of it."""
    chosen = request.form.get("chosen") == "yes"
    done = "goes into the final" if chosen else "is no longer chosen for the final"
    return _change_entry(name, partial(entries.choose, run_id=run_id, chosen=chosen), done)


def _change_entry(
    name: str, change: Callable[[Session, CompetitionView, TeamView], None], done: str
) -> ResponseReturnValue:
    """Change an entry of the captain's team, and say that it `done`."""
    competition, team = competition_access.captain_of(name)
    try:
        with services().database.writing() as session:
            change(session, competition, team)
    except CompetitionRefused as refusal:
        flash(str(refusal), "bad")
    else:
        flash(f"This entry {done}.", "good")
    return _team(name)


def _shown(
    competition: CompetitionView, team: TeamView, errors: dict[str, str] | None = None
) -> str:
    with services().database.reading() as session:
        submitted = entries.own(session, competition, team.id)
        texts = methods.of_team(session, team.id)
    entered = {entry.method.casefold(): entry.method for entry in reversed(submitted)}
    current, plan = competition.current, competition.document.final
    begun = competition.ended_at is not None or (
        competition.final is not None and competition.final.batches > 0
    )
    return render_template(
        "competitions/team.html",
        competition=competition,
        scenario=competitions.scenario_of(competition),
        team=team,
        entries=submitted[:ENTRIES_SHOWN],
        more=max(len(submitted) - ENTRIES_SHOWN, 0),
        left=None if current is None else entries.left(submitted, current),
        names={member.user_id: member.name for member in team.members},
        is_captain=team.captain_id == g.viewer.user_id,
        chooses=plan is not None and plan.carry is Carry.CHOSEN and not begun,
        begun=begun,
        kinds=wording.ROUND_KINDS,
        link=site_address()
        + url_for("competition_teams.invitation", name=competition.name, code=team.code),
        described={method: texts.get(key, "") for key, method in entered.items()},
        text_max=methods.TEXT_MAX,
        name_max=teams.NAME_MAX,
        errors=errors or {},
        name=request.form.get("team", team.name),
    )


def _invitation(competition: CompetitionView, team: TeamView, errors: dict[str, str]) -> str:
    return render_template(
        "competitions/join.html",
        competition=competition,
        team=team,
        programs=wording.PROGRAMS[competition.document.programs],
        errors=errors,
    )


def _invited(name: str, code: str) -> tuple[CompetitionView, TeamView]:
    """Return a competition and the team with a code; raises Problem not-found."""
    competition = competition_access.shown(name)
    with services().database.reading() as session:
        team = teams.invited(session, code)
    if team is None or team.competition_id != competition.id:
        raise Problem("not-found", teams.UNKNOWN_CODE)
    return competition, team


def _require_agreed() -> None:
    if request.form.get(AGREED) != "on":
        raise CompetitionRefused(_NOT_AGREED, field=AGREED)


def _team(name: str) -> ResponseReturnValue:
    return redirect(url_for("competition_teams.show", name=name), code=303)
