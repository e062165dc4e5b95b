"""`seamark db`."""

import json

import pytest
from click.testing import CliRunner
from sqlalchemy import delete, select

from seamark.cli.main import cli
from seamark.server.database import schema
from seamark.server.database.engine import Database
from seamark.server.database.schema import SchemaTooOld
from seamark.server.database.tables import Best
from seamark.server.runs.leaderboard import reference_entries
from seamark.server.settings import Settings
from tests.cast import Backend
from tests.services.prepared import SEAMARK, printed

BEST = tuple(Best.__table__.columns)


@pytest.fixture
def leaderboard(settings: Settings, database: Database, monkeypatch: pytest.MonkeyPatch) -> Backend:
    """A service with two entries on its leaderboard, which the command finds by its settings."""
    backend = Backend.with_cast(database, settings)
    for who in ("ann", "eva"):
        backend.published(who, kind="ranked")
    for variable, value in settings.environment().items():
        monkeypatch.setenv(variable, value)
    return backend


def _rows(backend: Backend) -> set[tuple[str, ...]]:
    with backend.database.reading() as session:
        return {tuple(map(repr, row)) for row in session.execute(select(*BEST))}


@pytest.mark.parametrize("damage", ["none", "one", "all"])
def test_a_rebuilt_leaderboard_has_the_rows_that_the_service_kept(
    leaderboard: Backend, damage: str
) -> None:
    kept = _rows(leaderboard)
    removed = {"none": (), "one": ("ann",), "all": ("ann", "eva")}[damage]
    with leaderboard.database.writing() as session:
        user_ids = [leaderboard.user_id(name) for name in removed]
        session.execute(delete(Best).where(Best.user_id.in_(user_ids)))

    answer = CliRunner().invoke(cli, ["db", "rebuild-leaderboard"])

    assert (answer.exit_code, len(kept)) == (0, 2)
    assert "2 entries" in answer.output
    assert _rows(leaderboard) == kept


def test_a_downgraded_database_can_be_upgraded_again(leaderboard: Backend) -> None:
    kept, runner = _rows(leaderboard), CliRunner()

    down = runner.invoke(cli, ["db", "downgrade", "0031"])
    with pytest.raises(SchemaTooOld, match="at schema 0031"):
        schema.check(leaderboard.database.engine)
    up = runner.invoke(cli, ["db", "upgrade"])

    assert (down.exit_code, up.exit_code) == (0, 0)
    schema.check(leaderboard.database.engine)
    assert {row[:2] for row in _rows(leaderboard)} == {row[:2] for row in kept}


def test_a_downgrade_to_an_unknown_schema_is_refused(leaderboard: Backend) -> None:
    answer = CliRunner().invoke(cli, ["db", "downgrade", "9999"])

    assert answer.exit_code != 0
    assert "9999" in answer.output + str(answer.exception)
    schema.check(leaderboard.database.engine)


@pytest.mark.slow
def test_the_missing_reference_entries_are_queued_once(leaderboard: Backend) -> None:
    words = ["db", "reference-entries", "--json"]
    first = json.loads(printed(SEAMARK, *words, on="warm"))["runs"]
    again = json.loads(CliRunner().invoke(cli, words).stdout)["runs"]

    with leaderboard.database.reading() as session:
        queued = reference_entries.live_count(session)
    assert (len(first), again) == (queued, [])
    assert queued > 0
