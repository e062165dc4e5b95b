"""The archive of a decided competition: rules, boards, methods, audit, citation and its runs."""

import zipfile
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from seamark.server.competitions import competitions
from seamark.server.competitions.competitions import CompetitionView, RoundView
from seamark.server.database.competition_tables import Entry
from seamark.server.database.engine import Database
from seamark.server.judging import audit_file, boards, methods
from seamark.server.judging.boards import BoardRow
from seamark.server.runs.downloads import export, zip_stream
from seamark.server.runs.publication import citations
from seamark.server.runs.publication.citations import Author, Citation
from seamark.server.runs.showing import views
from seamark.server.settings import Settings
from seamark.server.web import csv_export
from seamark.server.web.template_filters import iso

BOARD_COLUMNS = (
    *("place", "place_low", "place_high", "team", "method", "run"),
    *("score", "score_low", "score_high", "submissions", "submitted_at", "refusal"),
)
_README = """{title}
{line}

competition.json   what was asked: rules, scenario and rounds, frozen when the competition opened
boards/            places and scores of each round: one row for each method
methods.json       how the teams describe their methods
audit.json         commitments, keys, seeds and scores: `seamark competition audit audit.json`
runs/              the runs that decided it: configuration, metrics, and programs by the rules
CITATION.cff       how to cite it; the same as citation.bib and .zenodo.json

{address}
"""


def archive(
    database: Database, settings: Settings, competition: CompetitionView, address: str
) -> Iterator[bytes]:
    """Yield a zip archive of a decided competition; it holds no transaction while it is read."""

    def write(file: zipfile.ZipFile) -> Iterator[None]:
        title = competition.document.title
        readme = _README.format(title=title, line="=" * len(title), address=address)
        file.writestr("README.txt", readme)
        file.writestr("competition.json", export.as_json(competition.document.canonical()))
        with database.reading() as session:
            tables = [_board(session, competition, one) for one in competition.rounds]
            described = _described(session, competition, tables[-1])
            audit = audit_file.audit_of(session, competition, settings)
            file.writestr("audit.json", export.as_json(audit))
            picture = competitions.picture(session, competition.id)
            runs = _runs(session, competition)
        if picture is not None:
            file.writestr("picture", picture)
        for one, table in zip(competition.rounds, tables, strict=True):
            rows = (*table.rows, *table.references)
            name = f"boards/round-{one.number}-{one.kind}.csv"
            file.writestr(name, csv_export.lines(BOARD_COLUMNS, map(board_values, rows)))
        file.writestr("methods.json", export.as_json(described))
        for name, text in citations.files(citation_of(competition, address)).items():
            file.writestr(name, text)
        yield
        for run_id in runs:
            with database.reading() as session:
                run = views.show(session, run_id)
            if run is not None and run.public:
                program = run.program_public
                yield from export.write_run(file, settings, run, telemetry=False, program=program)

    return zip_stream.pieces(write)


def board_values(row: BoardRow) -> dict[str, Any]:
    """Return a row of a board by the names of `BOARD_COLUMNS`; reference entries have no team."""
    same = ("place", "place_low", "place_high", "team", "method", "score", "submissions", "refusal")
    return {name: getattr(row, name) for name in same} | {
        "run": row.run_id,
        "score_low": row.low,
        "score_high": row.high,
        "submitted_at": iso(row.submitted_at),
    }


def citation_of(competition: CompetitionView, address: str) -> Citation:
    """Return the citation of a decided competition."""
    document, ended_at = competition.document, competition.ended_at or 0.0
    methods_of = "1 team" if competition.teams == 1 else f"{competition.teams} teams"
    return Citation(
        key=f"seamark-{competition.name}",
        subject=f"competition {document.title}",
        author=Author(name=competition.organiser or "The organiser"),
        title=document.title,
        benchmark=f"{competition.name} (based on {document.benchmark})",
        address=address,
        published=datetime.fromtimestamp(ended_at, UTC).date(),
        licence=None,
        is_software=False,
        note=f"{methods_of}. Rules and scenario: SHA-256 {competition.digest}.",
    )


def _described(
    session: Session, competition: CompetitionView, board: boards.Board
) -> list[dict[str, str]]:
    """Return the methods that were placed, as their teams describe them."""
    texts = methods.texts(session, competition.id)
    return [
        {
            "team": row.team,
            "method": row.method,
            "description": texts.get((row.team_id or 0, row.method.casefold()), ""),
        }
        for row in board.rows
    ]


def _board(session: Session, competition: CompetitionView, one: RoundView) -> boards.Board:
    return boards.board(session, competition, one, by_method=True)


def _runs(session: Session, competition: CompetitionView) -> list[int]:
    """Return the runs that decided a competition, in the order of their numbers."""
    query = select(Entry.run_id).where(Entry.round_id == competition.deciding.id)
    return list(session.scalars(query.where(Entry.withdrawn_at.is_(None)).order_by(Entry.run_id)))
