"""The results of a decided competition, for people who were not there: podium, replays, proofs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from flask import Blueprint, Response, make_response, render_template, url_for
from flask.typing import ResponseReturnValue

from seamark.server.competitions import teams
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.judging import audit_file, boards, certificates, methods
from seamark.server.judging.boards import Board, BoardRow
from seamark.server.judging.certificates import Certificate
from seamark.server.pages.compare import compare
from seamark.server.pages.competitions import wording
from seamark.server.pages.competitions.competitions import Scenario, scenario_of
from seamark.server.pages.competitions.shown_board import shown_board
from seamark.server.runs.downloads.export import as_json
from seamark.server.runs.publication import citations
from seamark.server.runs.showing import views
from seamark.server.runs.showing.side_by_side import RUNS_MAX, RUNS_MIN
from seamark.server.runs.showing.views import RunView
from seamark.server.web import competition_access, competition_archive, security_headers
from seamark.server.web.problems import Problem
from seamark.server.web.rate_limits import PROOFS, client, limiter
from seamark.server.web.services import services
from seamark.server.web.site_address import site_address
from seamark.server.web.template_filters import score

PODIUM = 3  # places
EMBEDDED = 10  # rows that a frame of another page shows
page = Blueprint("results", __name__, url_prefix="/competitions")


@dataclass(frozen=True, slots=True)
class Method:
    """A method that was placed, as its team describes it."""

    row: BoardRow
    text: str


@page.get("/<name>/results")
def show(name: str) -> ResponseReturnValue:
    """Show how a competition was decided."""
    competition = _decided(name)
    with services().database.reading() as session:
        by_method = boards.board(session, competition, competition.deciding, by_method=True)
        by_team = by_method.per_team()
        podium = _podium(by_team)
        ids = [row.run_id for row in podium]
        runs = [run for run in views.several(session, ids, metrics=True) if _has_data(run)]
        texts = methods.texts(session, competition.id)
    names = {row.run_id: f"{row.team}: {row.method}" for row in podium}
    address = _address(competition)
    return render_template(
        "competitions/results.html",
        competition=competition,
        scenario=scenario_of(competition),
        one=competition.deciding,
        podium=podium,
        compared=compare.views_of(runs, names) if len(runs) >= RUNS_MIN else None,
        alone=runs[0] if len(runs) == 1 else None,
        board=shown_board(by_method, None, 0),
        methods=_methods(by_method, texts),
        certified=[row for row in by_team.rows if row.place is not None],
        bibtex=citations.bibtex(competition_archive.citation_of(competition, address)),
        frame=f"{site_address()}{url_for('results.embed', name=competition.name)}",
        kinds=wording.ROUND_KINDS,
    )


@page.get("/<name>/results/embed")
def embed(name: str) -> ResponseReturnValue:
    """Show the first places alone, for the frame of another page."""
    competition = _decided(name)
    board = _board(competition)
    answer = make_response(
        render_template(
            "competitions/embed.html",
            competition=competition,
            scenario=scenario_of(competition),
            rows=[row for row in board.rows if row.place is not None][:EMBEDDED],
            count=len(board.rows),
        )
    )
    return security_headers.embeddable(answer, services().settings.embed_origins)


@page.get("/<name>/audit.json")
@limiter.limit(PROOFS, key_func=client)
def audit(name: str) -> ResponseReturnValue:
    """Send what anybody needs to check a competition, as far as its rounds are decided."""
    competition = competition_access.shown(name)
    held = services()
    with held.database.reading() as session:
        text = as_json(audit_file.audit_of(session, competition, held.settings))
    return _attachment(Response(text, mimetype="application/json"), f"{name}-audit.json")


@page.get("/<name>/archive.zip")
@limiter.limit(PROOFS, key_func=client)
def archive(name: str) -> ResponseReturnValue:
    """Send all of a decided competition as one archive."""
    competition, held = _decided(name), services()
    pieces = competition_archive.archive(
        held.database, held.settings, competition, _address(competition)
    )
    return _attachment(Response(pieces, mimetype="application/zip"), f"{name}.zip")


@page.get("/<name>/certificates/<row:team_id>.svg")
def certificate(name: str, team_id: int) -> ResponseReturnValue:
    """Send the certificate of a team that has a place."""
    competition = _decided(name)
    board = _board(competition)
    row = next((row for row in board.of_team(team_id) if row.place is not None), None)
    if row is None:
        raise Problem("not-found", "This team has no place in the competition.")
    with services().database.reading() as session:
        team = teams.find(session, team_id)
    members = [] if team is None else [each.name for each in team.members]
    drawn = certificates.drawn(_certificate(competition, board, row, members))
    return Response(drawn, mimetype="image/svg+xml")


def _decided(name: str) -> CompetitionView:
    competition = competition_access.shown(name)
    if competition.ended_at is None:
        raise Problem("not-found", f"The competition {name} is not decided yet.")
    return competition


def _board(competition: CompetitionView) -> Board:
    with services().database.reading() as session:
        return boards.board(session, competition, competition.deciding)


def _podium(board: Board) -> list[BoardRow]:
    """Return the rows on the podium: those that share its last place too, as far as they fit."""
    placed = [row for row in board.rows if row.place is not None and row.place <= PODIUM]
    return placed[:RUNS_MAX]


def _has_data(run: RunView) -> bool:
    return run.data_deleted_at is None


def _methods(board: Board, texts: Mapping[tuple[int, str], str]) -> list[Method]:
    """Return the methods that were placed and are described."""
    described = (
        Method(row, texts.get((row.team_id or 0, row.method.casefold()), "")) for row in board.rows
    )
    return [method for method in described if method.text]


def _certificate(
    competition: CompetitionView, board: Board, row: BoardRow, members: Sequence[str]
) -> Certificate:
    scenario: Scenario = scenario_of(competition)
    value = f"{scenario.score} {score(row.score)} {scenario.unit}".strip()
    if row.low is not None and row.high is not None:
        value += f" ({score(row.low)} to {score(row.high)})"
    sure = row.place_low == row.place_high
    one, ended = competition.deciding, datetime.fromtimestamp(competition.ended_at or 0.0, UTC)
    return Certificate(
        competition=competition.document.title,
        place=row.place or 0,
        of=sum(each.place is not None for each in board.rows),
        ranks="" if sure else f", ranks {row.place_low} to {row.place_high} are possible (95 %)",
        team=row.team,
        members=", ".join(members),
        method=row.method,
        score=value,
        trials=one.plan.trials * max(one.batches, 1),
        organiser=competition.organiser,
        date=f"{ended.day} {ended:%B %Y}",
        address=_address(competition),
        digest=competition.digest,
    )


def _address(competition: CompetitionView) -> str:
    return f"{site_address()}{url_for('results.show', name=competition.name)}"


def _attachment(answer: Response, name: str) -> Response:
    answer.headers.set("Content-Disposition", "attachment", filename=name)
    return answer
