"""Bring a database to this version's schema; Alembic is configured here, not in a file."""

from collections.abc import Callable
from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, Engine

from seamark import migrations
from seamark.server.database.engine import Database
from seamark.server.database.tables import Base
from seamark.server.settings import Settings

_FOLDER = Path(migrations.__file__).parent


class SchemaTooOld(Exception):
    """The database has not been brought to this version. The text names the command."""


def upgrade(settings: Settings) -> None:
    """Make or change the tables, up to this version; safe to call at each start."""
    database = Database(settings.database_url)
    try:
        with database.engine.begin() as connection:
            command.upgrade(config(connection), "head")
    finally:
        database.close()


def check(engine: Engine) -> None:
    """Raise SchemaTooOld unless the database has exactly this version's schema."""
    with engine.connect() as connection:
        there = MigrationContext.configure(connection).get_current_revision()
    wanted = ScriptDirectory.from_config(config()).get_current_head()
    if there != wanted:
        raise SchemaTooOld(
            f"the database is at schema {there}, this version needs {wanted}: "
            "run `seamark db upgrade`"
        )


def config(connection: Connection | None = None) -> Config:
    """Return Alembic's configuration, for `connection` if there is one."""
    made = Config()
    made.set_main_option("script_location", str(_FOLDER).replace("%", "%%"))
    made.attributes["connection"] = connection
    return made


def run_environment(
    attributes: dict[str, object], configure: Callable[..., None], run: Callable[[], None]
) -> None:
    """Do what Alembic's env.py is for: batch mode, so that SQLite can change its tables too."""
    configure(
        connection=attributes["connection"],
        target_metadata=Base.metadata,
        render_as_batch=True,
        compare_type=True,
    )
    run()
