"""The database: one engine per process, explicit transactions."""

import sqlite3
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.exc import InterfaceError, InternalError, OperationalError
from sqlalchemy.orm import Session

from seamark.server.database import session_limits

CONNECT_S = 5  # until PostgreSQL counts as away
# libpq: a host that vanished without a word is noticed after half a minute rather than two hours.
_POSTGRESQL = {
    "connect_timeout": CONNECT_S,
    "keepalives_idle": 10,
    "keepalives_interval": 5,
    "keepalives_count": 4,
    "tcp_user_timeout": 30_000,  # [ms]
}
DATABASE_AWAY = (OperationalError, InterfaceError)  # or held up by others for too long
BUSY_S = 10.0  # a statement waits this long for another writer
IDLE_S = 15.0  # half a lease: an open transaction between two statements, on PostgreSQL
_RETRY_S = 0.01
_AFTER_COMMIT = "after_commit"  # key of what a session does then


class Database:
    """Opens sessions: `writing` commits at the end, `reading` never writes.

    On SQLite a writing transaction starts with BEGIN IMMEDIATE: with the driver's default, 1258 of
    2000 concurrent increments were lost; with a deferred BEGIN, 988 failed as "locked".

    On PostgreSQL a transaction whose process stands still, or whose machine has vanished, is ended
    by the server after `idle_s`, and a statement waits at most `busy_s` for a lock. Both reach the
    caller as an OperationalError, as does a database that is away.

    Parameters
    ----------
    busy_s
        How long a statement waits for another writer.
    idle_s
        How long a transaction may stand between two statements; 0: for ever.
    """

    def __init__(self, url: str, *, busy_s: float = BUSY_S, idle_s: float = IDLE_S) -> None:
        remote = not url.startswith("sqlite")
        options = _POSTGRESQL if remote else {}
        self.engine = create_engine(
            url,
            pool_pre_ping=remote,
            connect_args=options,
            hide_parameters=True,  # errors are logged, and passwords and tokens are parameters
        )
        if self.engine.dialect.name == "sqlite":
            _prepare_sqlite(self.engine, busy_s)
            self._readers = self.engine.execution_options(seamark_readonly=True)
        else:
            _prepare_postgresql(self.engine, session_limits.chosen(busy_s=busy_s, idle_s=idle_s))
            # One snapshot for all queries of a page, as SQLite gives it: a run must not be queued
            # in the first and running in the second.
            self._readers = self.engine.execution_options(
                postgresql_readonly=True, isolation_level="REPEATABLE READ"
            )

    @contextmanager
    def writing(self) -> Iterator[Session]:
        """Yield a session whose changes are committed at the end, or rolled back on an error."""
        with Session(self.engine, expire_on_commit=False) as session:
            with session.begin():
                yield session
            for action in session.info.pop(_AFTER_COMMIT, ()):
                action()

    @contextmanager
    def reading(self) -> Iterator[Session]:
        """Yield a session for queries. Keep it short: an open reader keeps SQLite's WAL growing."""
        with Session(self._readers, autoflush=False, expire_on_commit=False) as session:
            yield session

    def close(self) -> None:
        """Close all connections."""
        self.engine.dispose()


def after_commit(session: Session, action: Callable[[], object]) -> None:
    """Call `action` when what the session of `Database.writing` does is committed."""
    session.info.setdefault(_AFTER_COMMIT, []).append(action)


def size_bytes(connection: Connection) -> int:
    """Return how much room the database takes [B]."""
    if connection.dialect.name != "sqlite":
        size = connection.exec_driver_sql("SELECT pg_database_size(current_database())")
        return int(size.scalar_one())
    pages, of_page = (
        connection.exec_driver_sql(f"PRAGMA {name}").scalar_one()
        for name in ("page_count", "page_size")
    )
    return int(pages * of_page)


def _prepare_postgresql(engine: Engine, limits: Mapping[str, int]) -> None:
    @event.listens_for(engine, "connect")
    def _connect(connection: Any, _record: object) -> None:
        connection.autocommit = True  # or a rollback would take the limits back
        connection.execute(session_limits.STATEMENT, session_limits.parameters(limits))
        connection.autocommit = False

    @event.listens_for(engine, "handle_error")
    def _handle_error(context: Any) -> Exception | None:
        # The driver files a transaction that the server has ended for standing still under bugs.
        error = context.sqlalchemy_exception
        if isinstance(error, InternalError) and context.is_disconnect:
            return OperationalError(error.statement, error.params, context.original_exception)
        return None


def _prepare_sqlite(engine: Engine, busy_s: float) -> None:
    @event.listens_for(engine, "connect")
    def _connect(connection: Any, _record: object) -> None:
        connection.isolation_level = None  # the driver must not send a BEGIN of its own
        cursor = connection.cursor()
        cursor.execute(f"PRAGMA busy_timeout={busy_s * 1000:.0f}")
        _switch_to_wal(cursor, busy_s)
        cursor.execute("PRAGMA synchronous=NORMAL")
        cursor.execute("PRAGMA foreign_keys=ON")
        cursor.close()

    @event.listens_for(engine, "begin")
    def _begin(connection: Any) -> None:
        readonly = connection.get_execution_options().get("seamark_readonly")
        connection.exec_driver_sql("BEGIN" if readonly else "BEGIN IMMEDIATE")


def _switch_to_wal(cursor: sqlite3.Cursor, busy_s: float) -> None:
    """Have SQLite keep a write-ahead log; wait for a process that writes to a new database.

    SQLite itself does not wait here, whatever `busy_timeout` says, since it could be a deadlock.
    """
    deadline = time.monotonic() + busy_s
    while True:
        try:
            cursor.execute("PRAGMA journal_mode=WAL")
        except sqlite3.OperationalError as error:
            if error.sqlite_errorcode != sqlite3.SQLITE_BUSY or time.monotonic() > deadline:
                raise
            time.sleep(_RETRY_S)
        else:
            return
