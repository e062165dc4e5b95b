"""The data folder and the database belong together: each knows the other by the same mark.

With the disk of the data folder not mounted, an empty folder remains. A service that took it for a
new one would draw another key for the seeds, and write into the wrong disk.
"""

import secrets

from sqlalchemy import Connection, String, insert, select
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server import storage
from seamark.server.database.tables import Base
from seamark.server.settings import Settings


class DataFolder(Base):
    """The mark of the data folder: one row."""

    __tablename__ = "data_folder"

    mark: Mapped[str] = mapped_column(String(64), primary_key=True)


class WrongDataFolder(Exception):
    """The data folder is not the one of the database. The text says what to do."""


def adopt(connection: Connection, settings: Settings) -> None:
    """Mark the data folder of a new database; raise WrongDataFolder if it has another one."""
    file = storage.mark(settings.data)
    known = connection.scalar(select(DataFolder.mark))
    if known is not None:
        _compare(known, settings)
        return
    if not file.exists():
        file.write_text(secrets.token_hex(16), encoding="utf-8")
    mark = file.read_text(encoding="utf-8").strip()
    connection.execute(insert(DataFolder).values(mark=mark))


def check(connection: Connection, settings: Settings) -> None:
    """Raise WrongDataFolder unless the data folder is the one of the database."""
    known = connection.scalar(select(DataFolder.mark))
    if known is not None:
        _compare(known, settings)


def _compare(known: str, settings: Settings) -> None:
    file = storage.mark(settings.data)
    try:
        found = file.read_text(encoding="utf-8").strip()
    except OSError:
        found = ""
    if found != known:
        raise WrongDataFolder(
            f"{settings.data} is not the data folder of this database. Is its disk mounted? To use "
            f"it from now on, write {known} into {file}"
        )
