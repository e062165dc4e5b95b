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
from seamark.server.runs.leaderboard import best_runs, leaderboard
from seamark.server.runs.leaderboard.board_rows import Rank
from seamark.server.runs.leaderboard.per import Per
from seamark.server.runs.record.solutions import entry_name
from tests.cast import Backend

WORKER_0031 = """
    INSERT INTO workers (name, slots, level, languages, findings, started_at, seen_at)
    VALUES ('old', 2, 'medium', '["python"]', '[]', 0.0, :seen_at)
"""


def _but_the_expression(_item: object, name: str | None, *_rest: object) -> bool:
    # SQLAlchemy cannot read an index over "score DESC" back from SQLite.
    return name not in ("ix_best_rank", "ix_best_methods_rank")


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


def test_an_upgrade_lists_the_methods_of_everybody_once_a_worker_has_been_at_work(
    both: Backend,
) -> None:
    names = ["PI", "Observer", "pi", "Übung"]
    for who, name in [*(("ann", name) for name in names), ("ben", "Only one")]:
        both.published(who, kind="ranked", title=name)
    before = _leaderboard(both, Per.METHOD)
    with both.database.engine.begin() as connection:
        command.downgrade(config(connection), "0036")

    upgrade(both.settings)
    at_once = _leaderboard(both, Per.METHOD)
    with both.database.writing() as session:
        completed = best_runs.complete(session), best_runs.complete(session)

    assert len(before) == 3 + 1
    assert [rank.user for rank in at_once] == ["ann", "ben"]
    assert completed == (1, 0)
    assert _leaderboard(both, Per.METHOD) == before


def _leaderboard(both: Backend, per: Per = Per.PERSON) -> list[Rank]:
    with both.database.reading() as session:
        return leaderboard.page(session, "currents-v1", per=per)


PAGE = "SELECT * FROM {} WHERE benchmark = 'b' ORDER BY score DESC, reached_at, run_id LIMIT 50"
NEXT_PAGE = PAGE.replace("ORDER", "AND score <= 5 AND NOT (score > 5 OR run_id < 3) ORDER")
COUNT = "SELECT count(*) FROM {} WHERE benchmark = 'b' AND score >= 4 AND NOT is_baseline"
TABLES = pytest.mark.parametrize("table", ["best", "best_methods"])


@TABLES
def test_counting_people_or_methods_reads_the_index_alone(database: Database, table: str) -> None:
    query = text(f"EXPLAIN QUERY PLAN {COUNT.format(table)}")
    with database.reading() as session:
        plan = " ".join(map(str, session.execute(query)))

    assert f"USING COVERING INDEX ix_{table}_rank" in plan


@TABLES
@pytest.mark.parametrize("rows", [PAGE, NEXT_PAGE])
def test_the_queries_of_the_leaderboard_use_its_index(both: Backend, rows: str, table: str) -> None:
    query = rows.format(table)
    explain = "EXPLAIN QUERY PLAN " if both.settings.database_url[0] == "s" else "EXPLAIN "

    with both.database.reading() as session:
        plan = " ".join(str(row) for row in session.execute(text(explain + query)))

    assert f"ix_{table}_rank" in plan


def test_a_database_without_tables_is_reported_as_too_old(database_url: str) -> None:
    database = Database(database_url)

    with pytest.raises(SchemaTooOld, match="seamark db upgrade"):
        check(database.engine)
