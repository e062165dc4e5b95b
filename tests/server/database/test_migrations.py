import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from sqlalchemy import select, text

from seamark.server.database.engine import Database
from seamark.server.database.schema import SchemaTooOld, check, upgrade
from seamark.server.database.tables import Base, User
from tests.cast import Backend


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
