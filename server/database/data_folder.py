"""The storage and the database belong together: each knows the other by the same mark.

With the disk of the data folder not mounted, an empty folder remains. A service that took it for a
new one would draw another key for the seeds, and write into the wrong disk.
"""

import hmac
import secrets
from pathlib import Path

from sqlalchemy import Connection, String, Text, insert, select, update
from sqlalchemy.orm import Mapped, Session, mapped_column

from seamark.server.database.result_code import difference, result_code
from seamark.server.database.tables import Base
from seamark.server.settings import Settings
from seamark.server.storage import objects, storage
from seamark.server.storage.objects import ObjectsAway


class DataFolder(Base):
    """The mark of the storage, and what else all machines of the service share: one row."""

    __tablename__ = "data_folder"

    mark: Mapped[str] = mapped_column(String(64), primary_key=True)
    seed_proof: Mapped[str | None] = mapped_column(String(64))  # tells one seed key from another
    result_code: Mapped[str | None] = mapped_column(Text)  # of the version that last upgraded


CURRENT_CODE = select(DataFolder.result_code).scalar_subquery()
_OTHER_SEEDS = (
    "SEAMARK_SEED_KEY, or the file seed_key in the data folder, is not the key of this service: "
    "ranked runs would get other seeds. Give this machine the key of the others"
)


class WrongDataFolder(Exception):
    """This machine does not belong to the service of the database. The text says what to do."""


def unfinished(data: Path) -> Path:
    """Return the file that is there while a backup is restored, and after a restore that failed."""
    return data / "restoring"


def adopt(connection: Connection, settings: Settings) -> None:
    """Mark the storage of a new database, and record what decides results.

    Raises
    ------
    WrongDataFolder
        It has another storage, or other seeds.
    """
    _refuse_unfinished(settings.data)
    known = connection.scalar(select(DataFolder.mark))
    if known is not None:
        _compare(known, settings)
    else:
        mark = _stored_mark(settings)
        if not mark:
            mark = secrets.token_hex(16)
            _write(mark, settings)
        connection.execute(insert(DataFolder).values(mark=mark))
    _compute_alike(connection, settings)


def _compute_alike(connection: Connection, settings: Settings) -> None:
    """Record what decides results from now on; raise WrongDataFolder for another seed key."""
    proof = _seed_proof(settings)
    known = connection.scalar(select(DataFolder.seed_proof))
    if known not in (None, proof):
        raise WrongDataFolder(_OTHER_SEEDS)
    values = {"seed_proof": proof, "result_code": result_code()}
    connection.execute(update(DataFolder).values(**values))


def check_worker(connection: Connection, settings: Settings) -> None:
    """Raise WrongDataFolder unless a worker with these settings computes what all others do."""
    if why := other_seeds(connection, settings) or other_code(connection):
        raise WrongDataFolder(why)


def other_seeds(connection: Connection, settings: Settings) -> str | None:
    """Return why ranked runs would get other seeds here than elsewhere; None if they do not."""
    proof = connection.scalar(select(DataFolder.seed_proof))
    is_other = settings.derives_seeds and proof not in (None, _seed_proof(settings))
    return _OTHER_SEEDS if is_other else None


def other_code(connection: Connection) -> str | None:
    """Return why a worker would compute other results here than elsewhere; None if it does not."""
    code = connection.scalar(select(CURRENT_CODE))
    if code in (None, result_code()):
        return None
    return (
        "This worker would not compute the results of this service: it has "
        f"{difference(result_code(), code)}. Install the version that the other machines have, "
        "or run `seamark db upgrade` with this one, after which older workers get no more runs"
    )


def computes_alike(session: Session) -> bool:
    """Return whether this process computes what the service does now."""
    return session.scalar(select(CURRENT_CODE)) in (None, result_code())


def _seed_proof(settings: Settings) -> str:
    key = settings.seed_key.encode()
    return hmac.new(key, b"this key derives the seeds of Seamark", "sha256").hexdigest()


def check(connection: Connection, settings: Settings) -> None:
    """Raise WrongDataFolder unless the storage is the one of the database."""
    _refuse_unfinished(settings.data)
    known = connection.scalar(select(DataFolder.mark))
    if known is not None:
        _compare(known, settings)


def known_mark(session: Session) -> str | None:
    """Return the mark of the storage that is the one of the database; None if it has none yet."""
    return session.scalar(select(DataFolder.mark))


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
    if _stored_mark(settings) == known:
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


def _stored_mark(settings: Settings) -> str:
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
