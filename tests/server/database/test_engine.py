import multiprocessing
import sqlite3
import threading
import time
from pathlib import Path

import pytest
from sqlalchemy import select, text
from sqlalchemy.exc import OperationalError

from seamark.server.database import session_limits
from seamark.server.database.engine import Database
from seamark.server.database.queue_tables import Turn

PROCESSES, TIMES = 3, 60


def _count_up(url: str) -> None:
    database = Database(url)
    for _ in range(TIMES):
        with database.writing() as session:
            turn = session.get_one(Turn, "x")
            turn.served_at += 1.0
    database.close()


@pytest.mark.slow
def test_concurrent_writers_lose_no_update(database: Database) -> None:
    with database.writing() as session:
        session.add(Turn(owner="x", served_at=0.0))
    url = database.engine.url.render_as_string(hide_password=False)
    database.close()  # SQLite is not to be carried through a fork
    context = multiprocessing.get_context("fork")
    writers = [context.Process(target=_count_up, args=(url,)) for _ in range(PROCESSES)]

    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()

    with database.reading() as session:
        assert session.scalar(select(Turn.served_at)) == PROCESSES * TIMES


def test_an_error_rolls_its_transaction_back(database: Database) -> None:
    def write_and_fail() -> None:
        with database.writing() as session:
            session.add(Turn(owner="x", served_at=0.0))
            session.flush()
            raise KeyError("x")

    with pytest.raises(KeyError):
        write_and_fail()

    with database.reading() as session:
        assert session.scalar(select(Turn.owner)) is None


def test_a_new_sqlite_file_that_another_process_writes_to_is_waited_for(tmp_path: Path) -> None:
    file = tmp_path / "new.sqlite"
    writer = sqlite3.connect(file, isolation_level=None, check_same_thread=False)
    writer.execute("CREATE TABLE t (n INTEGER)")  # not yet in WAL mode
    writer.execute("BEGIN IMMEDIATE")
    end = threading.Timer(0.3, writer.execute, ["COMMIT"])
    end.start()

    database = Database(f"sqlite:///{file}")
    with database.reading() as session:
        mode = session.connection().exec_driver_sql("PRAGMA journal_mode").scalar()

    end.join()
    writer.close()
    database.close()
    assert mode == "wal"


def test_a_postgresql_host_that_vanishes_is_noticed_within_a_minute(postgres_url: str) -> None:
    database = Database(postgres_url)
    with database.reading() as session:
        driver = session.connection().connection.driver_connection
        assert driver is not None
        chosen = {name: int(value) for name, value in driver.info.get_parameters().items()
                  if name.startswith(("keepalives", "tcp_user"))}  # fmt: skip
    database.close()

    quiet_s = chosen["keepalives_idle"] + chosen["keepalives_interval"] * chosen["keepalives_count"]
    assert quiet_s < 60
    assert 1000 < chosen["tcp_user_timeout"] < 60_000


def test_a_transaction_that_stands_still_is_ended_and_told_as_a_database_that_is_away(
    postgres_url: str,
) -> None:
    database = Database(postgres_url, idle_s=0.1)

    def stand_still() -> None:
        with database.writing() as session:
            session.execute(text("SELECT pg_advisory_xact_lock(1)"))
            time.sleep(0.5)  # as a process does that is stopped and goes on
            session.execute(text("SELECT 1"))

    with pytest.raises(OperationalError):
        stand_still()
    with database.writing() as session:
        free = session.scalar(text("SELECT pg_try_advisory_xact_lock(1)"))
    database.close()

    assert free is True


def test_a_statement_does_not_wait_for_ever_for_a_lock(postgres_url: str) -> None:
    database = Database(postgres_url, busy_s=0.1)
    lock = text("SELECT pg_advisory_xact_lock(1)")

    with database.writing() as first, database.writing() as second:
        first.execute(lock)
        with pytest.raises(OperationalError):
            second.execute(lock)

    database.close()


def test_the_limits_of_a_session_outlast_a_transaction_that_is_rolled_back(
    postgres_url: str,
) -> None:
    database = Database(postgres_url)
    with pytest.raises(KeyError), database.writing():
        raise KeyError

    with database.engine.connect() as connection:
        found = session_limits.find(connection)
    database.close()

    assert found == session_limits.Findings([], pooled=False)


def test_a_session_without_limits_is_found(postgres_url: str) -> None:
    database = Database(postgres_url, idle_s=0.0)

    with database.engine.connect() as connection:
        found = session_limits.find(connection)
    database.close()

    assert found.missing == ["idle_in_transaction_session_timeout"]
