"""`seamark db`."""

import pytest
from click.testing import CliRunner
from sqlalchemy import delete, select

from seamark.cli.main import cli
from seamark.server.database.engine import Database
from seamark.server.database.tables import Best
from seamark.server.settings import Settings
from tests.cast import Backend

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


def _rows(backend: Backend) -> set[tuple[object, ...]]:
    with backend.database.reading() as session:
        return {tuple(row) for row in session.execute(select(*BEST))}


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
