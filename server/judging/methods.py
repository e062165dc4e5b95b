"""How teams describe their methods; everybody reads it with the results."""

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from seamark.sandbox.printable_text import visible_text
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.competitions.teams import TeamView
from seamark.server.database.competition_tables import Entry, MethodText, Team
from seamark.server.database.upsert import upsert

TEXT_MAX = 2000  # [character]


def describe(session: Session, team: TeamView, method: str, text: str) -> None:
    """Give a method of a team a description, or none if it is empty.

    Raises
    ------
    CompetitionRefused
        The team has not entered the method, or the description is too long.
    """
    key, text = method.casefold(), visible_text(text, keep="\n").strip()
    entered = select(Entry.run_id).where(Entry.team_id == team.id, Entry.method_key == key)
    if session.scalar(entered.limit(1)) is None:
        raise CompetitionRefused("Your team has not entered this method.", field="method")
    if len(text) > TEXT_MAX:
        raise CompetitionRefused(
            f"A description has at most {TEXT_MAX} characters; yours has {len(text)}.", field="text"
        )
    if text:
        row = {"team_id": team.id, "method_key": key, "text": text}
        upsert(session, MethodText, row, {"text": text})
    else:
        own = (MethodText.team_id == team.id, MethodText.method_key == key)
        session.execute(delete(MethodText).where(*own))


def texts(session: Session, competition_id: int) -> dict[tuple[int, str], str]:
    """Return the descriptions by team and by the case-folded name of the method."""
    query = (
        select(MethodText)
        .join(Team, Team.id == MethodText.team_id)
        .where(Team.competition_id == competition_id)
    )
    return {(row.team_id, row.method_key): row.text for row in session.scalars(query)}


def of_team(session: Session, team_id: int) -> dict[str, str]:
    """Return the descriptions of a team by the case-folded name of the method."""
    own = select(MethodText).where(MethodText.team_id == team_id)
    return {row.method_key: row.text for row in session.scalars(own)}
