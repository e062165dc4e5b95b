"""Teams: a captain makes one and hands out its link; an entry belongs to the team."""

import time
from dataclasses import dataclass

from sqlalchemy import delete, func, select, update
from sqlalchemy.orm import Session

from seamark.sandbox.printable_text import visible_text
from seamark.server.accounts import join_codes
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.competition_tables import Competition, Entry, Team, TeamMember
from seamark.server.database.tables import User

NAME_MAX = 60  # [character]
TEAMS_MAX = 2000  # of a competition
LISTED_MAX = 2000
OWNER = "team:"  # start of the owner of a team's entries
UNKNOWN_CODE = "No team has this link any more. Ask its captain for the current one."


@dataclass(frozen=True, slots=True)
class Member:
    """A member of a team."""

    user_id: int
    name: str
    joined_at: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TeamView:
    """A team as its members see it; the code is for them alone."""

    id: int
    competition_id: int
    name: str
    code: str
    captain_id: int | None
    members: tuple[Member, ...]

    @property
    def owner(self) -> str:
        """The key under which its entries are queued and counted."""
        return f"{OWNER}{self.id}"

    def has(self, user_id: int | None) -> bool:
        """Return whether an account is a member."""
        return any(each.user_id == user_id for each in self.members)


def found(session: Session, competition: CompetitionView, user_id: int, name: str) -> int:
    """Make a team with a captain, who agrees on the rules, and return its id.

    Raises
    ------
    CompetitionRefused
        The name is taken, or the account is in a team or organises the competition.
    """
    name = _valid_name(name)
    acquire(session, AdvisoryLock.TEAMS)
    _require_joinable(session, competition, user_id, "")
    if competition.teams >= TEAMS_MAX:
        raise CompetitionRefused(f"This competition already has {TEAMS_MAX} teams.")
    _require_free(session, competition.id, name)
    made = Team(
        competition_id=competition.id,
        name=name,
        name_key=name.casefold(),
        code=join_codes.new(),
        captain_id=user_id,
        created_at=time.time(),
    )
    session.add(made)
    session.flush()
    _add(session, made, user_id)
    return made.id


def join(session: Session, competition: CompetitionView, user_id: int, code: str) -> int:
    """Add an account, which agrees on the rules, to the team with this code or link; its id.

    Joining again changes nothing.

    Raises
    ------
    CompetitionRefused
        There is no such team, it is full, or the account is in another one or organises it.
    """
    acquire(session, AdvisoryLock.TEAMS)
    team = invited(session, code)
    if team is None or team.competition_id != competition.id:
        raise CompetitionRefused(UNKNOWN_CODE, field="code")
    if team.has(user_id):
        return team.id
    _require_joinable(session, competition, user_id, team.name)
    if len(team.members) >= competition.document.team_size:
        raise CompetitionRefused(
            f"The team {team.name} is full: {competition.document.team_size} members at most."
        )
    row = session.get_one(Team, team.id)
    _add(session, row, user_id)
    if row.captain_id is None:
        row.captain_id = user_id
    return team.id


def leave(session: Session, team: TeamView, user_id: int) -> None:
    """End a membership; entries stay the team's. The next member becomes captain."""
    own = (TeamMember.team_id == team.id, TeamMember.user_id == user_id)
    session.execute(delete(TeamMember).where(*own))
    appoint_captains(session, user_id, team_id=team.id)


def leave_all(session: Session, user_id: int) -> None:
    """End all memberships of an account that is deleted."""
    session.execute(delete(TeamMember).where(TeamMember.user_id == user_id))
    appoint_captains(session, user_id)
    mine = update(Entry).where(Entry.user_id == user_id)
    session.execute(mine.values(user_id=None))
    organised = update(Competition).where(Competition.organiser_id == user_id)
    session.execute(organised.values(organiser_id=None))


def appoint_captains(session: Session, gone: int, *, team_id: int | None = None) -> None:
    """Make the member who joined first the captain of teams whose captain is gone."""
    which = Team.captain_id == gone
    if team_id is not None:
        which &= Team.id == team_id
    first = (
        select(TeamMember.user_id)
        .where(TeamMember.team_id == Team.id)
        .order_by(TeamMember.joined_at, TeamMember.user_id)
        .limit(1)
        .scalar_subquery()
    )
    session.execute(update(Team).where(which).values(captain_id=first))


def change(
    session: Session,
    team: TeamView,
    *,
    name: str | None = None,
    captain_id: int | None = None,
    new_code: bool = False,
) -> None:
    """Change what is given.

    Raises
    ------
    CompetitionRefused
        The name is taken or empty, or the new captain is no member.
    """
    values: dict[str, object] = {}
    if name is not None:
        name = _valid_name(name)
        if name.casefold() != team.name.casefold():
            acquire(session, AdvisoryLock.TEAMS)
            _require_free(session, team.competition_id, name)
        values |= {"name": name, "name_key": name.casefold()}
    if captain_id is not None:
        if not team.has(captain_id):
            raise CompetitionRefused("Only a member can be the captain.", field="captain")
        values["captain_id"] = captain_id
    if new_code:
        values["code"] = join_codes.new()
    if values:
        session.execute(update(Team).where(Team.id == team.id).values(**values))


def find(session: Session, team_id: int) -> TeamView | None:
    """Return a team; None if it does not exist."""
    row = session.get(Team, team_id)
    return None if row is None else _view(session, row)


def of_user(session: Session, competition_id: int, user_id: int | None) -> TeamView | None:
    """Return the team that an account is in, in a competition."""
    if user_id is None:
        return None
    member = session.get(TeamMember, (competition_id, user_id))
    return None if member is None else find(session, member.team_id)


def invited(session: Session, code: str) -> TeamView | None:
    """Return the team that people can join with this code, or a link that ends with it."""
    row = session.scalar(select(Team).where(Team.code == join_codes.read(code)))
    return None if row is None else _view(session, row)


def memberships(session: Session, user_id: int) -> dict[int, str]:
    """Return competition -> name of the team that an account is in."""
    query = (
        select(Team.competition_id, Team.name)
        .join(TeamMember, TeamMember.team_id == Team.id)
        .where(TeamMember.user_id == user_id)
    )
    return {competition: name for competition, name in session.execute(query)}


def names(session: Session, competition_id: int) -> dict[int, str]:
    """Return the names of all teams of a competition, by their ids."""
    query = select(Team.id, Team.name).where(Team.competition_id == competition_id)
    return {team: name for team, name in session.execute(query.limit(LISTED_MAX))}


def _add(session: Session, team: Team, user_id: int) -> None:
    session.add(
        TeamMember(
            competition_id=team.competition_id,
            user_id=user_id,
            team_id=team.id,
            joined_at=time.time(),
        )
    )
    session.flush()


def _require_joinable(
    session: Session, competition: CompetitionView, user_id: int, name: str
) -> None:
    """Raise CompetitionRefused if an account may not be in the team of this name.

    Whoever has submitted for a team goes back to none but that: with another one came another
    quota, and more finalists.
    """
    if competition.is_draft or competition.qualification.has_closed:
        raise CompetitionRefused("Teams are made and joined until the qualification closes.")
    if competition.organiser_id == user_id:
        raise CompetitionRefused("You organise this competition, so you cannot take part in it.")
    if session.get(TeamMember, (competition.id, user_id)) is not None:
        raise CompetitionRefused("You are in a team of this competition. Leave it first.")
    earlier = (
        select(Team.name)
        .join(Entry, Entry.team_id == Team.id)
        .where(Team.competition_id == competition.id, Entry.user_id == user_id)
    )
    if (before := session.scalar(earlier.limit(1))) not in (None, name):
        raise CompetitionRefused(
            f"You have submitted for the team {before}. Join it again: ask for its link."
        )


def _require_free(session: Session, competition_id: int, name: str) -> None:
    same = (Team.competition_id == competition_id, Team.name_key == name.casefold())
    if session.scalar(select(func.count()).where(*same)):
        raise CompetitionRefused(f"There is a team {name}. Choose another name.", field="name")


def _view(session: Session, row: Team) -> TeamView:
    query = (
        select(User.id, User.name, TeamMember.joined_at)
        .join(TeamMember, TeamMember.user_id == User.id)
        .where(TeamMember.team_id == row.id)
        .order_by(TeamMember.joined_at, User.id)
    )
    same = ("id", "competition_id", "name", "captain_id")
    return TeamView(
        **{name: getattr(row, name) for name in same},
        code=join_codes.shown(row.code),
        members=tuple(Member(*member) for member in session.execute(query)),
    )


def _valid_name(name: str) -> str:
    name = " ".join(visible_text(name).split())
    if not 1 <= len(name) <= NAME_MAX:
        raise CompetitionRefused(f"A team has a name of 1 to {NAME_MAX} characters.", field="name")
    return name
