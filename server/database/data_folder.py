"""The data folder and the database belong together: each knows the other by the same mark.

With the disk of the data folder not mounted, an empty folder remains. A service that took it for a
new one would draw another key for the seeds, and write into the wrong disk.
"""

import secrets
from pathlib import Path

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


def unfinished(data: Path) -> Path:
    """Return the file that is there while a backup is restored, and after a restore that failed."""
    return data / "restoring"


def adopt(connection: Connection, settings: Settings) -> None:
    """Mark the data folder of a new database; raise WrongDataFolder if it has another one."""
    _refuse_unfinished(settings.data)
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
    _refuse_unfinished(settings.data)
    known = connection.scalar(select(DataFolder.mark))
    if known is not None:
        _compare(known, settings)


def mark_restored(connection: Connection, settings: Settings) -> None:
    """Mark the data folder as that of a database which has been restored."""
    known = connection.scalar(select(DataFolder.mark))
    if known is not None:
        storage.mark(settings.data).write_text(known, encoding="utf-8")


def _refuse_unfinished(data: Path) -> None:
    if unfinished(data).exists():
        raise WrongDataFolder(
            f"Restoring a backup into {data} has not finished. If it is not running any more, "
            "start it again with --force"
        )


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
