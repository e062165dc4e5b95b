"""Access of the current request to competitions and teams, for pages and the API alike.

Whoever may not see a draft gets the same answer as for a competition that is not there.
"""

from flask import g

from seamark.competitions.document import RoundKind
from seamark.server.accounts.permissions import Action, can, organises
from seamark.server.competitions import competitions, teams
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.competitions.teams import TeamView
from seamark.server.web import access
from seamark.server.web.problems import Problem
from seamark.server.web.services import services


def shown(name: str) -> CompetitionView:
    """Return a competition that is open, or a draft of the viewer's."""
    with services().database.reading() as session:
        found = competitions.find(session, name)
    if found is None or (found.is_draft and not is_organiser(found)):
        raise Problem("not-found", f"There is no competition {name}.")
    return found


def organised(name: str) -> CompetitionView:
    """Return a competition of the viewer, or any one for an admin."""
    access.require(Action.ORGANISE)
    found = shown(name)
    if not is_organiser(found):
        raise Problem("forbidden", "Only the organiser of the competition may do this.")
    return found


def is_organiser(competition: CompetitionView) -> bool:
    """Return whether the viewer has the rights of the organiser."""
    return organises(access.viewer(), competition.organiser_id)


def own_team(competition: CompetitionView) -> TeamView | None:
    """Return the viewer's team in a competition, if there is one."""
    with services().database.reading() as session:
        return teams.of_user(session, competition.id, g.viewer.user_id)


def member_of(name: str, action: Action = Action.COMPETE) -> tuple[CompetitionView, TeamView]:
    """Return a competition and the viewer's team in it; the viewer may perform `action`."""
    access.require_account(action)
    competition = shown(name)
    team = own_team(competition)
    if team is None:
        raise Problem("forbidden", "You are in no team of this competition.")
    return competition, team


def captain_of(name: str) -> tuple[CompetitionView, TeamView]:
    """Return a competition and the team whose captain the viewer is."""
    competition, team = member_of(name)
    if team.captain_id != g.viewer.user_id:
        raise Problem("forbidden", "Only the captain of the team may do this.")
    return competition, team


def sees_board(competition: CompetitionView, number: int) -> bool:
    """Return whether the viewer sees the scores of a round: all do, or the organiser alone."""
    one = competition.rounds[number - 1]
    sealed = one.kind is RoundKind.FINAL and one.decided_at is None
    return one.shows_board or (is_organiser(competition) and not sealed)


def may_organise() -> bool:
    """Return whether the viewer may make competitions."""
    return can(access.viewer(), Action.ORGANISE)
