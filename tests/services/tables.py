"""The tables of a new service, copied from a database that was migrated once in a test session."""

import tempfile
from contextlib import closing
from functools import cache
from pathlib import Path

from sqlalchemy import delete, make_url

from seamark.server.database import data_folder
from seamark.server.database.data_folder import DataFolder
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.settings import Settings


def create(settings: Settings) -> Database:
    """Do what `schema.upgrade` does to a new SQLite database, without its migrations."""
    path = make_url(settings.database_url).database
    assert path is not None
    Path(path).write_bytes(_migrated())
    return adopt(settings)


def adopt(settings: Settings) -> Database:
    """Make a copied database that of `settings`, as the end of `schema.upgrade` does."""
    database = Database(settings.database_url)
    with database.engine.begin() as connection:
        data_folder.adopt(connection, settings)
    return database


def migrate(url: str) -> None:
    """Migrate a new database to be copied: it is not yet that of any data folder."""
    with tempfile.TemporaryDirectory() as folder:
        upgrade(Settings.model_validate({"data": folder, "database_url": url}))
    with closing(Database(url)) as database, database.writing() as session:
        session.execute(delete(DataFolder))


@cache
def _migrated() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "tables.db")
        migrate(f"sqlite:///{file}")
        return file.read_bytes()
