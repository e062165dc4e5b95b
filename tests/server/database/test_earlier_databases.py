"""A database that the commit 70b00c53 has made is opened, and gets the schema that a new one has.

`earlier/sqlite.sql.gz` is that of its `seamark up` with the runs of two people,
`earlier/postgresql.sql.gz` the schema that it made in PostgreSQL, without rows.
"""

import gzip
import re
import sqlite3
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Connection, create_engine, inspect, select

from seamark.server.administration.backup import tables
from seamark.server.database import schema
from seamark.server.database.engine import Database
from seamark.server.database.tables import Best
from seamark.server.runs.leaderboard import best_runs, leaderboard
from seamark.server.settings import Settings
from tests.cast import Backend

EARLIER = Path(__file__).parent / "earlier"
MARK = "a9da43ca93ec387dd5749c22f896265d"  # of its data folder
DIGEST = "76905d894bffa2c25611adb24f0a13920612a16438061f1dc577c5b7bf536f5e"  # of the published run
PUBLISHED, FAILED, LAST = 27, 29, 31  # runs


def _sql(name: str) -> str:
    return gzip.decompress((EARLIER / f"{name}.sql.gz").read_bytes()).decode()


@pytest.fixture
def sqlite_url(tmp_path: Path) -> str:
    file = tmp_path / "earlier.db"
    connection = sqlite3.connect(file)
    connection.executescript(_sql("sqlite"))
    connection.close()
    return f"sqlite:///{file}"


@pytest.fixture
def postgresql_url(sqlite_url: str, postgres_url: str) -> str:
    source, target = create_engine(sqlite_url), create_engine(postgres_url)
    with source.connect() as rows, target.begin() as connection:
        connection.exec_driver_sql(_sql("postgresql"))
        for name, _count, chunk in tables.dump(rows):
            tables.load(connection, name, chunk)
        tables.count_on(connection)
    source.dispose()
    target.dispose()
    return postgres_url


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.host)])
def settings_of_each(
    request: pytest.FixtureRequest, settings: Settings, tmp_path: Path
) -> tuple[Settings, Settings]:
    """Settings of a service with such a database, and of one without tables; of each type."""
    url = request.getfixturevalue(f"{request.param}_url")
    new = f"sqlite:///{tmp_path / 'new.db'}"
    if request.param == "postgresql":
        new = request.getfixturevalue("other_postgres_url")
    (settings.data / "seamark-data").write_text(MARK)
    elsewhere = settings.model_copy(update={"data": tmp_path / "new", "database_url": new})
    earlier = {"database_url": url, "seed_key": "of the earlier service"}
    return settings.model_copy(update=earlier), elsewhere


def test_it_gets_the_schema_of_a_new_database(
    settings_of_each: tuple[Settings, Settings],
) -> None:
    earlier, new = map(_upgraded, settings_of_each)

    assert earlier == new
    assert earlier["runs"]["columns"]["trial_seeds"] == ("JSON", True, None)


def _upgraded(settings: Settings) -> dict[str, Any]:
    settings.data.mkdir(exist_ok=True)
    schema.upgrade(settings)
    schema.check_all(settings)
    engine = create_engine(settings.database_url)
    with engine.connect() as connection:
        described = _described(connection)
    engine.dispose()
    return described


def _described(connection: Connection) -> dict[str, Any]:
    """Return all that can be read back from a schema, without the order of columns."""
    found = inspect(connection)
    return {
        table: {
            "columns": {
                each["name"]: (str(each["type"]), each["nullable"], each["default"])
                for each in found.get_columns(table)
            },
            "key": found.get_pk_constraint(table),
            "foreign keys": _by_name(found.get_foreign_keys(table)),
            "rules": _by_name(found.get_check_constraints(table)),
            "unique": _by_name(found.get_unique_constraints(table)),
            "indexes": {
                each["name"]: (
                    *(each["column_names"], each["unique"]),
                    [_plain(rows) for rows in each["dialect_options"].values()],
                )
                for each in found.get_indexes(table)
            },
        }
        for table in found.get_table_names()
    }


def _by_name(parts: list[Any]) -> list[dict[str, str]]:
    plain = [{key: _plain(value) for key, value in part.items()} for part in parts]
    return sorted(plain, key=lambda part: part["name"])


def _plain(value: object) -> str:
    """Return the text of a part, without the casts that a dump of PostgreSQL groups otherwise."""
    return re.sub(r"::(character varying|text)(\[\])?|[()]", "", str(value))


def test_its_runs_and_leaderboard_are_there(settings_of_each: tuple[Settings, Settings]) -> None:
    settings, _ = settings_of_each
    schema.upgrade(settings)
    database = Database(settings.database_url)
    backend = Backend(database, settings, {})

    with database.reading() as session:
        [first] = leaderboard.page(session, "currents-v1")
        rows = [*session.execute(select(Best.__table__))]
    with database.writing() as session:
        assert best_runs.rebuild(session) == 2  # the other one is a reference entry
        assert [*session.execute(select(Best.__table__))] == rows
    published, failed = backend.show(PUBLISHED), backend.show(FAILED)
    database.close()

    assert (first.run_id, first.user, first.method) == (PUBLISHED, "ann", "Linear from example")
    assert first.score == pytest.approx(84.66174130583298)
    assert published.digest == DIGEST
    assert failed.cause == "user_error"


def test_its_queue_goes_on(settings_of_each: tuple[Settings, Settings]) -> None:
    settings, _ = settings_of_each
    schema.upgrade(settings)
    backend = Backend(Database(settings.database_url), settings, {})
    backend.sign_up("eva")

    new = backend.queue("eva")
    claimed = backend.claim_next()
    reference_entry = backend.claim_next()
    backend.database.close()

    assert (claimed.run_id, new > LAST) == (new, True)  # users go first
    assert 1 < reference_entry.run_id < PUBLISHED
