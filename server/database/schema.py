"""Migrates a database to the schema of this version. Alembic is configured here, without a file."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, Engine

from seamark import migrations
from seamark.failures import PlatformFailed
from seamark.server.database import advisory_locks, data_folder
from seamark.server.database.account_tables import AccountDeletion
from seamark.server.database.advisory_locks import AdvisoryLock
from seamark.server.database.class_tables import Classroom
from seamark.server.database.competition_tables import Competition
from seamark.server.database.connecting import connected
from seamark.server.database.engine import Database
from seamark.server.database.mail_tables import MailAddress
from seamark.server.database.operation_tables import AuditEntry, DiskUsage
from seamark.server.database.publication_tables import Publication, RankPoint
from seamark.server.database.queue_tables import Turn
from seamark.server.database.rejudgement_tables import Rejudgement
from seamark.server.database.submission_tables import KeyOfSubmission, Sweep
from seamark.server.database.tables import Base
from seamark.server.settings import Settings

# The last commit whose migrations begin before the schema 0031.
LAST_TO_UPGRADE_ALL = "093b11f4"
UPGRADE_S = 600.0  # a process waits this long for one that upgrades a large database

_FOLDER = Path(migrations.__file__).parent
# A table of each module of tables: its import declares the others of the module.
_TABLES = (
    *(Turn, RankPoint, Classroom, AccountDeletion, Sweep, KeyOfSubmission, AuditEntry, DiskUsage),
    *(Rejudgement, MailAddress, Publication, Competition),
)


class SchemaTooOld(Exception):
    """The database has an earlier schema. The text names the command to run."""


class SchemaUnknown(PlatformFailed):
    """A schema is of a newer version of Seamark, or too old to be upgraded. The text says more."""


def upgrade(settings: Settings) -> None:
    """Create or migrate the tables; safe to call at every start, also by several processes.

    Raises
    ------
    DatabaseAway, SchemaUnknown
        The database cannot be opened, or has a schema that this version does not know.
    WrongDataFolder
        The database has another data folder.
    """
    with _locked(settings) as connection:
        _refuse_unknown(revision_of(connection))
        command.upgrade(config(connection), "head")
        data_folder.adopt(connection, settings)


def downgrade(settings: Settings, revision: str) -> None:
    """Return to an earlier schema, for an earlier version; what only the later one stores is lost.

    Raises
    ------
    CommandError
        There is no such revision.
    DatabaseAway, SchemaUnknown
        The database cannot be opened, or has a schema that this version does not know.
    """
    with _locked(settings) as connection:
        _refuse_unknown(revision_of(connection))
        command.downgrade(config(connection), revision)


@contextmanager
def replaced(settings: Settings, revision: str) -> Iterator[Connection]:
    """Yield a connection to new, empty tables of a schema, in place of those that there were.

    What is inserted is upgraded to the schema of this version, all in one transaction.
    """
    with _locked(settings) as connection:
        Base.metadata.drop_all(connection)
        connection.exec_driver_sql("DROP TABLE IF EXISTS alembic_version")
        command.upgrade(config(connection), revision)
        yield connection
        command.upgrade(config(connection), "head")


@contextmanager
def _locked(settings: Settings) -> Iterator[Connection]:
    """Yield a connection with a transaction in which no other process changes the schema.

    It may stand for as long as it takes, between two rows of a backup on a slow disk.
    """
    database = Database(settings.database_url, busy_s=UPGRADE_S, idle_s=0.0)
    try:
        with connected(database.engine) as connection, connection.begin():
            advisory_locks.acquire(connection, AdvisoryLock.SCHEMA)
            yield connection
    finally:
        database.close()


def check_all(settings: Settings, *, computes: bool = False) -> None:
    """Check that a process of the service can start.

    Parameters
    ----------
    computes
        It is a worker: it also has to compute what the others do.

    Raises
    ------
    DatabaseAway
        The database cannot be opened.
    SchemaTooOld, SchemaUnknown, WrongDataFolder
        The database has another schema than this version, or is of another service.
    """
    database = Database(settings.database_url)
    try:
        check(database.engine)
        with database.engine.connect() as connection:
            data_folder.check(connection, settings)
            if computes:
                data_folder.check_worker(connection, settings)
    finally:
        database.close()


def check(engine: Engine) -> None:
    """Raise SchemaTooOld or SchemaUnknown unless the database has the schema of this version.

    Raises DatabaseAway if it cannot be opened.
    """
    with connected(engine) as connection:
        current = revision_of(connection)
    _refuse_unknown(current)
    needed = newest_revision()
    if current != needed:
        raise SchemaTooOld(
            f"the database is at schema {current}, this version needs {needed}: "
            "run `seamark db upgrade`"
        )


def _refuse_unknown(revision: str | None) -> None:
    if revision is None or knows(revision):
        return
    if is_too_early(revision):
        raise SchemaUnknown(
            f"The database has the schema {revision}, of a version before the first release that "
            f"this one cannot upgrade. Run `seamark db upgrade` with the commit "
            f"{LAST_TO_UPGRADE_ALL} of Seamark, when the service is stopped and backed up, and "
            "then this version again."
        )
    newest = newest_revision()
    raise SchemaUnknown(
        f"The database has the schema {revision}, of a newer version of Seamark; this is "
        f"{version('seamark')}, which knows schemas up to {newest}. Install the newer version, or "
        "go back with it, when the service is stopped and backed up: "
        f"`seamark db downgrade {newest}`."
    )


def revision_of(connection: Connection) -> str | None:
    """Return the schema of a database; None if it has no tables of Seamark."""
    return MigrationContext.configure(connection).get_current_revision()


def newest_revision() -> str | None:
    """Return the schema of this version."""
    return ScriptDirectory.from_config(config()).get_current_head()


def knows(revision: str) -> bool:
    """Return whether a schema is that of this version or of one that it upgrades."""
    scripts = ScriptDirectory.from_config(config()).walk_revisions()
    return any(script.revision == revision for script in scripts)


def is_too_early(revision: str) -> bool:
    """Return whether a schema is of a version that stored it before the first one known here."""
    first = ScriptDirectory.from_config(config()).get_base()
    return first is not None and revision < first


def config(connection: Connection | None = None) -> Config:
    """Return the configuration of Alembic, for a connection if there is one."""
    alembic = Config()
    alembic.set_main_option("script_location", str(_FOLDER).replace("%", "%%"))
    alembic.attributes["connection"] = connection
    return alembic


def run_environment(
    attributes: dict[str, object], configure: Callable[..., None], run: Callable[[], None]
) -> None:
    """Run migrations for Alembic's env.py; in batch mode, so that SQLite can alter its tables."""
    configure(
        connection=attributes["connection"],
        target_metadata=Base.metadata,
        render_as_batch=True,
        compare_type=True,
    )
    run()
