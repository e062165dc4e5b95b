"""Competitions as everybody sees them: the list, and the page of each with rules and boards."""

from collections.abc import Mapping
from dataclasses import dataclass

from flask import Blueprint, Response, g, render_template, request
from flask.typing import ResponseReturnValue

from seamark.programs.setting_values import differences
from seamark.server.accounts.permissions import Action, can
from seamark.server.competitions import competitions, teams
from seamark.server.competitions.competitions import CompetitionView, RoundView
from seamark.server.competitions.teams import TeamView
from seamark.server.judging import boards, check, drafts, entries
from seamark.server.pages.competitions import wording
from seamark.server.pages.competitions.shown_board import shown_board
from seamark.server.web import competition_access
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

page = Blueprint("competitions", __name__, url_prefix="/competitions")
page.add_app_template_filter(wording.round_state)
page.add_app_template_filter(wording.state, "competition_state")


@dataclass(frozen=True, slots=True)
class Scenario:
    """What all entries of a competition have in common."""

    changes: list[tuple[str, str, str]]  # title, unit, value of what differs from the benchmark
    score: str  # what the board compares
    unit: str


@page.get("/")
def index() -> ResponseReturnValue:
    """List the competitions that everybody sees, and the viewer's drafts and teams."""
    user_id = g.viewer.user_id
    with services().database.reading() as session:
        listed = competitions.listed(session)
        organises = competition_access.may_organise() and user_id is not None
        own = competitions.drafts_of(session, user_id) if organises else []
        memberships = {} if user_id is None else teams.memberships(session, user_id)
    past = [one for one in listed if one.ended_at is not None]
    coming = [one for one in listed if one.ended_at is None and not one.rounds[0].has_opened]
    return render_template(
        "competitions/index.html",
        running=[one for one in listed if one not in past and one not in coming],
        coming=coming,
        past=past,
        drafts=own,
        memberships=memberships,
        organises=organises,
    )


@page.get("/<name>")
def show(name: str) -> ResponseReturnValue:
    """Show a competition with the board of a round; a draft with its check."""
    return shown(competition_access.shown(name))


@page.get("/<name>/picture")
def picture(name: str) -> ResponseReturnValue:
    """Send the picture of a competition."""
    competition = competition_access.shown(name)
    with services().database.reading() as session:
        content = competitions.picture(session, competition.id)
    if content is None:
        raise Problem("not-found", "The competition has no picture.")
    return Response(content, mimetype=drafts.media_type(content))


def shown(
    competition: CompetitionView,
    errors: Mapping[str, str] | None = None,
    posted: Mapping[str, str] | None = None,
) -> str:
    """Return the page of a competition, with what was wrong with the form of a new team."""
    if competition.is_draft:
        return _draft(competition)
    one, team = _chosen_round(competition), competition_access.own_team(competition)
    by_method = request.args.get("per") == "method"
    board, left = None, None
    with services().database.reading() as session:
        if one.has_opened and competition_access.sees_board(competition, one.number):
            found = boards.board(session, competition, one, by_method=by_method)
            board = shown_board(found, None if team is None else team.id, _first())
        if team is not None and competition.current is not None:
            left = entries.left(entries.own(session, competition, team.id), competition.current)
    return render_template(
        "competitions/show.html",
        competition=competition,
        scenario=scenario_of(competition),
        one=one,
        board=board,
        team=team,
        left=left,
        joins=_joins(competition, team),
        is_organiser=competition_access.is_organiser(competition),
        programs=wording.PROGRAMS[competition.document.programs],
        ties=wording.TIES[competition.document.ties],
        kinds=wording.ROUND_KINDS,
        team_name_max=teams.NAME_MAX,
        errors=errors or {},
        posted=posted or {},
    )


def scenario_of(competition: CompetitionView) -> Scenario:
    """Return what differs from the benchmark of a competition, and what its scores are."""
    document = competition.document
    with entries.lent(competition, services().settings):
        config = document.scenario()
        changes = differences(document.base, document.fixed())
    if config.custom_score():
        return Scenario(changes, "Score", "")
    headline = document.base.headline_of(config)
    return Scenario(changes, headline.label, headline.unit)


def _draft(competition: CompetitionView) -> str:
    with services().database.reading() as session:
        checked = check.view(session, competition)
    late = next((one for one in competition.rounds if one.has_closed), None)
    return render_template(
        "competitions/draft.html",
        competition=competition,
        scenario=scenario_of(competition),
        check=checked,
        late=late,
        programs=wording.PROGRAMS[competition.document.programs],
        ties=wording.TIES[competition.document.ties],
        kinds=wording.ROUND_KINDS,
    )


def _chosen_round(competition: CompetitionView) -> RoundView:
    """Return the round that the address names, else the one that is open or was the last."""
    number = request.args.get("round", "")
    named = next((one for one in competition.rounds if str(one.number) == number), None)
    opened = [one for one in competition.rounds if one.has_opened]
    if named is not None or competition.ended_at is not None:
        return named or competition.deciding
    # Before a final is decided nobody sees a score of it.
    with_rows = [one for one in opened if one.closes_at is not None]
    return with_rows[-1] if with_rows else competition.rounds[0]


def _first() -> int:
    text = request.args.get("from", "0")
    return int(text) if text.isdecimal() and len(text) < 6 else 0


def _joins(competition: CompetitionView, team: TeamView | None) -> bool:
    """Return whether to offer the form of a new team, or how to sign in for it."""
    if team is not None or competition.qualification.has_closed:
        return False
    if g.viewer.user_id is None:
        return True
    return can(g.viewer, Action.COMPETE) and competition.organiser_id != g.viewer.user_id
