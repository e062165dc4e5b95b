import time

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from sqlalchemy import select, text

from seamark.server.database.engine import Database
from seamark.server.database.schema import SchemaTooOld, check, config, upgrade
from seamark.server.database.tables import Base, User
from seamark.server.messaging import workers
from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.leaderboard.leaderboard import Rank
from seamark.server.runs.record.solutions import entry_name
from tests.cast import Backend

WORKER_0031 = """
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


@pytest.mark.slow
def test_an_upgrade_of_an_upgraded_database_changes_nothing(both: Backend) -> None:
    upgrade(both.settings)

    check(both.database.engine)
    with both.database.reading() as session:
        assert session.scalar(select(User.name).where(User.name == "ann"))


def test_a_database_of_the_first_schema_keeps_runs_leaderboard_and_workers(
    both: Backend,
) -> None:
    run_id = both.published("ann", kind="ranked", title="Observer")
    before, board = both.show(run_id), _leaderboard(both)
    with both.database.engine.begin() as connection:
        command.downgrade(config(connection), "0031")
        connection.execute(text(WORKER_0031), {"seen_at": time.time()})
    with pytest.raises(SchemaTooOld):
        check(both.database.engine)

    upgrade(both.settings)

    check(both.database.engine)
    assert both.show(run_id) == before
    assert _leaderboard(both) == board != []
    with both.database.reading() as session:
        (worker,) = workers.listed(session)
    assert (worker.name, worker.alive, worker.processes) == ("old", True, {})


def test_what_was_published_before_methods_had_names_is_called_as_before(both: Backend) -> None:
    titled = both.published("ann", title="Observer " + "x" * 100)
    program = {"controller": "upload", "program": both.store_program(name="mine.py")}
    untitled, private = both.published("ann", **program), both.succeeded("ann", title="Draft")
    with both.database.engine.begin() as connection:
        command.downgrade(config(connection), "0031")

    upgrade(both.settings)

    names = [both.show(run_id).method for run_id in (titled, untitled, private)]
    assert names == ["Observer " + "x" * 51, "", ""]
    assert entry_name(both.show(untitled)) == "mine.py"


def _leaderboard(both: Backend) -> list[Rank]:
    with both.database.reading() as session:
        return leaderboard.page(session, "currents-v1")


PAGE = "SELECT * FROM best WHERE benchmark = 'b' ORDER BY score DESC, reached_at, run_id LIMIT 50"
NEXT_PAGE = PAGE.replace("ORDER", "AND score <= 5 AND NOT (score > 5 OR run_id < 3) ORDER")
PEOPLE = "SELECT count(*) FROM best WHERE benchmark = 'b' AND score >= 4 AND NOT is_baseline"


def test_counting_people_reads_the_index_alone(database: Database) -> None:
    with database.reading() as session:
        plan = " ".join(map(str, session.execute(text(f"EXPLAIN QUERY PLAN {PEOPLE}"))))

    assert "USING COVERING INDEX ix_best_rank" in plan


@pytest.mark.parametrize("query", [PAGE, NEXT_PAGE])
def test_the_queries_of_the_leaderboard_use_its_index(both: Backend, query: str) -> None:
    explain = "EXPLAIN QUERY PLAN " if both.settings.database_url[0] == "s" else "EXPLAIN "

    with both.database.reading() as session:
        plan = " ".join(str(row) for row in session.execute(text(explain + query)))

    assert "ix_best_rank" in plan


def test_a_database_without_tables_is_reported_as_too_old(database_url: str) -> None:
    database = Database(database_url)

    with pytest.raises(SchemaTooOld, match="seamark db upgrade"):
        check(database.engine)
