"""The teams and the entries of a competition as CSV, for its organiser."""

from collections.abc import Iterator
from typing import Any

from seamark.server.competitions import teams
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.competitions.teams import TeamView
from seamark.server.database.engine import Database
from seamark.server.judging import entries
from seamark.server.judging.entries import EntryView
from seamark.server.web import csv_export
from seamark.server.web.template_filters import iso

TEAM_COLUMNS = ("team", "captain", "member", "joined_at")
ENTRY_COLUMNS = (
    *("team", "round", "run", "method", "submitted_by", "submitted_at", "state"),
    *("score", "score_low", "score_high", "refusal", "withdrawn", "chosen"),
)


def team_lines(database: Database, competition: CompetitionView) -> Iterator[str]:
    """Yield the members of all teams, team by team: no transaction stays open in between."""
    yield csv_export.lines(TEAM_COLUMNS, ())
    for team in _teams(database, competition):
        rows = [
            {
                "team": team.name,
                "captain": member.user_id == team.captain_id,
                "member": member.name,
                "joined_at": iso(member.joined_at),
            }
            for member in team.members
        ]
        yield csv_export.lines(TEAM_COLUMNS, rows, header=False)


def entry_lines(database: Database, competition: CompetitionView) -> Iterator[str]:
    """Yield what all teams submitted, team by team; nothing of a final that is not decided."""
    yield csv_export.lines(ENTRY_COLUMNS, ())
    for team in _teams(database, competition):
        names: dict[int | None, str] = {each.user_id: each.name for each in team.members}
        with database.reading() as session:
            submitted = entries.own(session, competition, team.id)
        rows = [_row(team, names.get(each.user_id, ""), each) for each in reversed(submitted)]
        yield csv_export.lines(ENTRY_COLUMNS, rows, header=False)


def _teams(database: Database, competition: CompetitionView) -> Iterator[TeamView]:
    with database.reading() as session:
        known = teams.names(session, competition.id)
    for team_id in known:
        with database.reading() as session:
            team = teams.find(session, team_id)
        if team is not None:
            yield team


def _row(team: TeamView, by: str, entry: EntryView) -> dict[str, Any]:
    same = ("method", "state", "score", "score_low", "score_high", "refusal", "chosen", "round")
    return {name: getattr(entry, name) for name in same} | {
        "team": team.name,
        "run": entry.run_id,
        "submitted_by": by,
        "submitted_at": iso(entry.submitted_at),
        "withdrawn": entry.withdrawn_at is not None,
    }
