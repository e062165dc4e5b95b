"""The storage and the database belong together: each knows the other by the same mark.

With the disk of the data folder not mounted, an empty folder remains. A service that took it for a
new one would draw another key for the seeds, and write into the wrong disk.
"""

import secrets
from pathlib import Path

from sqlalchemy import Connection, String, insert, select
from sqlalchemy.orm import Mapped, Session, mapped_column

from seamark.server import objects, storage
from seamark.server.database.tables import Base
from seamark.server.objects import ObjectsAway
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
    """Mark the storage of a new database; raise WrongDataFolder if it has another one."""
    _refuse_unfinished(settings.data)
    known = connection.scalar(select(DataFolder.mark))
    if known is not None:
        _compare(known, settings)
        return
    mark = _found(settings)
    if not mark:
        mark = secrets.token_hex(16)
        _write(mark, settings)
    connection.execute(insert(DataFolder).values(mark=mark))


def check(connection: Connection, settings: Settings) -> None:
    """Raise WrongDataFolder unless the storage is the one of the database."""
    _refuse_unfinished(settings.data)
    known = connection.scalar(select(DataFolder.mark))
    if known is not None:
        _compare(known, settings)


def is_own(session: Session, settings: Settings) -> bool:
    """Return whether the storage is the one of the database."""
    known = session.scalar(select(DataFolder.mark))
    return known is None or known == _found(settings)


def mark_restored(connection: Connection, settings: Settings) -> None:
    """Mark the storage as that of a database which has been restored."""
    known = connection.scalar(select(DataFolder.mark))
    if known is not None:
        _write(known, settings)


def _refuse_unfinished(data: Path) -> None:
    if unfinished(data).exists():
        raise WrongDataFolder(
            f"Restoring a backup into {data} has not finished. If it is not running any more, "
            "start it again with --force"
        )


def _compare(known: str, settings: Settings) -> None:
    if _found(settings) == known:
        return
    if settings.storage_url:
        raise WrongDataFolder(
            f"{settings.storage_url} is not the storage of this database. Is SEAMARK_STORAGE_URL "
            f"that of the other machines? To use it from now on, copy the data into it and write "
            f"{known} into its object {objects.MARK}"
        )
    raise WrongDataFolder(
        f"{settings.data} is not the data folder of this database. Is its disk mounted, or does "
        f"this machine need SEAMARK_STORAGE_URL? To use it from now on, write {known} into "
        f"{storage.mark(settings.data)}"
    )


def _found(settings: Settings) -> str:
    """Return the mark of the storage; empty without one."""
    stored = objects.of(settings)
    try:
        if stored is None:
            return storage.mark(settings.data).read_text(encoding="utf-8").strip()
        return (stored.get(objects.MARK) or b"").decode().strip()
    except OSError:
        return ""
    except ObjectsAway as error:
        raise WrongDataFolder(f"{settings.storage_url} cannot be used: {error}") from None


def _write(mark: str, settings: Settings) -> None:
    stored = objects.of(settings)
    if stored is None:
        storage.mark(settings.data).write_text(mark, encoding="utf-8")
        return
    try:
        stored.put(objects.MARK, mark.encode())
    except ObjectsAway as error:
        raise WrongDataFolder(f"{settings.storage_url} cannot be written: {error}") from None
