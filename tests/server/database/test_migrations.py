import time

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from sqlalchemy import select, text

from seamark.server import workers
from seamark.server.database.engine import Database
from seamark.server.database.schema import SchemaTooOld, check, config, upgrade
from seamark.server.database.tables import Base, User
from seamark.server.runs import leaderboard
from seamark.server.runs.leaderboard import Rank
from tests.cast import Backend

WORKER_0003 = """
    INSERT INTO workers (name, slots, level, languages, findings, started_at, seen_at)
    VALUES ('old', 2, 'medium', '["python"]', '[]', 0.0, :seen_at)
"""


def _but_the_expression(_item: object, name: str | None, *_rest: object) -> bool:
    # SQLAlchemy cannot read an index over "score DESC" back from SQLite.
    return name != "ix_best_rank"


def test_the_migrations_create_the_tables_of_the_code(both: Backend) -> None:
    with both.database.engine.connect() as connection:
        options = {"compare_type": True, "include_object": _but_the_expression}
        differences = compare_metadata(
            MigrationContext.configure(connection, opts=options), Base.metadata
        )

    assert differences == []


def test_an_upgrade_of_an_upgraded_database_changes_nothing(both: Backend) -> None:
    upgrade(both.settings)

    check(both.database.engine)
    with both.database.reading() as session:
        assert session.scalar(select(User.name).where(User.name == "ann"))


def test_a_database_of_the_previous_schema_keeps_runs_leaderboard_and_workers(
    both: Backend,
) -> None:
    run_id = both.published("ann", kind="ranked")
    before, board = both.show(run_id), _leaderboard(both)
    with both.database.engine.begin() as connection:
        command.downgrade(config(connection), "0003")
        connection.execute(text(WORKER_0003), {"seen_at": time.time()})
    with pytest.raises(SchemaTooOld):
        check(both.database.engine)

    upgrade(both.settings)

    check(both.database.engine)
    assert both.show(run_id) == before
    assert _leaderboard(both) == board != []
    with both.database.reading() as session:
        (worker,) = workers.listed(session)
    assert (worker.name, worker.alive, worker.processes) == ("old", True, {})


def test_the_ranked_submissions_of_a_database_of_the_previous_schema_are_counted(
    both: Backend,
) -> None:
    both.succeeded("ann", kind="ranked")
    both.failed({}, "ann")
    both.cancel(both.queue("ann", kind="ranked"))
    both.published("ann", kind="ranked")
    with both.database.engine.begin() as connection:
        command.downgrade(config(connection), "0004")

    upgrade(both.settings)

    assert [rank.submissions for rank in _leaderboard(both)] == [2]


def _leaderboard(both: Backend) -> list[Rank]:
    with both.database.reading() as session:
        return leaderboard.page(session, "currents-v1")


def test_the_query_of_the_leaderboard_uses_its_index(both: Backend) -> None:
    query = "SELECT * FROM best WHERE benchmark = 'b' ORDER BY score DESC, reached_at, user_id"
    explain = "EXPLAIN QUERY PLAN " if both.settings.database_url[0] == "s" else "EXPLAIN "

    with both.database.reading() as session:
        plan = " ".join(str(row) for row in session.execute(text(f"{explain}{query} LIMIT 50")))

    assert "ix_best_rank" in plan


def test_a_database_without_tables_is_reported_as_too_old(database_url: str) -> None:
    database = Database(database_url)

    with pytest.raises(SchemaTooOld, match="seamark db upgrade"):
        check(database.engine)
