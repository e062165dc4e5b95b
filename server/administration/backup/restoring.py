"""Restoring a backup into an empty service, or in place of one that has stopped.

The whole backup is verified before anything changes. Then a file in the data folder keeps services
from starting until everything is in place: what a crash leaves behind is not a whole service.
"""

import json
import os
import shutil
from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

from pydantic import ValidationError
from sqlalchemy import Connection, make_url, update

from seamark.server.accounts import audit
from seamark.server.accounts.audit import COMMAND_LINE, AuditAction
from seamark.server.administration.backup import archive, layout, tables
from seamark.server.administration.backup.archive import MODE, ArchiveRejected, Content, OnBytes
from seamark.server.administration.backup.layout import Header, Summary
from seamark.server.database import data_folder, schema
from seamark.server.database.engine import Database
from seamark.server.database.tables import Run
from seamark.server.messaging import workers
from seamark.server.runs.data import retention
from seamark.server.settings import KEY_FILES, Settings, kept
from seamark.server.storage import storage

DATA = ("runs", "programs")  # folders of the data folder
DERIVED = ("compiled", "cache", "workspace")  # belong to the service that was there


class RestoreRefused(Exception):
    """Nothing was changed. The text says why and what to do."""


def check(source: Path, on_bytes: OnBytes) -> Header:
    """Verify a whole backup and return its header; raises ArchiveRejected."""
    header, _ = _header_and_keys(source)
    archive.verify(source, on_bytes)
    return header


def restore(
    settings: Settings,
    source: Path,
    *,
    force: bool,
    on_bytes: OnBytes,
    locked: Callable[[Path], AbstractContextManager[None]] = lambda _: nullcontext(),
) -> Summary:
    """Restore a backup.

    Parameters
    ----------
    settings
        May lack the keys, which come from the backup.
    force
        Replace the service that is there: its accounts, runs and programs are lost.
    on_bytes
        Called with the number of bytes read since the last call; the backup is read twice.
    locked
        Locks the data folder, once it is known that the backup can be restored.

    Raises
    ------
    RestoreRefused, ArchiveRejected
        Nothing was changed. The exception is a backup with correct sums whose rows are not those of
        its own summary: it is rejected with the data folder cleared, and services do not start.
    """
    header, keys = _header_and_keys(source)
    _require_known(header)
    _require_same_storage(header, settings)
    _require_key(settings, keys["seed_key"])
    _require_free_target(settings, force=force)
    if not force:
        _require_room(settings.data, source.stat().st_size)
    archive.verify(source, on_bytes)
    settings.data.mkdir(parents=True, exist_ok=True, mode=0o700)
    with locked(settings.data):
        _require_free_target(settings, force=force)  # again, now that the folder is locked
        data_folder.unfinished(settings.data).write_text(f"{source}\n", encoding="utf-8")
        _clear(settings.data)
        with schema.replaced(settings, header.schema_revision) as connection:
            summary = _unpack(connection, settings, source, on_bytes)
        _finish(settings, keys, source)
    return summary


def _header_and_keys(source: Path) -> tuple[Header, dict[str, str]]:
    """Return the header and the keys; every backup begins with them."""
    header, keys = None, dict[str, str]()
    for member, content in archive.members(source, lambda _: None):
        name = layout.key_of(member)
        if member == layout.HEADER:
            header = _header(source, content.read())
        elif name is None:
            break
        else:
            keys[name] = content.read().decode()
    if header is None or keys.keys() != {*layout.KEYS} or not all(keys.values()):
        raise ArchiveRejected(f"{source} is not a backup of Seamark")
    return header, keys


def _header(source: Path, text: bytes) -> Header:
    try:
        return Header.model_validate_json(text)
    except ValidationError:
        raise ArchiveRejected(f"{source} is not a backup of Seamark") from None


def _require_known(header: Header) -> None:
    """Refuse a backup of a later version, and one that the migrations cannot bring up."""
    if schema.is_too_early(header.schema_revision):
        raise RestoreRefused(
            f"The backup has the schema {header.schema_revision}, of a version before the first "
            "release that this one cannot upgrade. Restore it with the commit "
            f"{schema.LAST_TO_UPGRADE_ALL} of Seamark and back that service up"
        )
    if header.format != layout.FORMAT or not schema.knows(header.schema_revision):
        raise RestoreRefused(
            f"The backup was made by Seamark {header.version} with schema "
            f"{header.schema_revision}, which is later than this version knows "
            f"({schema.newest_revision()}). Restore it with Seamark {header.version} or later"
        )


def _require_same_storage(header: Header, settings: Settings) -> None:
    """Refuse a backup without files for a data folder, and one with files for object storage."""
    if header.objects and not settings.storage_url:
        raise RestoreRefused(
            "The backup is of a service with object storage, where its programs and the data of "
            "its runs are. Set SEAMARK_STORAGE_URL"
        )
    if settings.storage_url and not header.objects:
        raise RestoreRefused(
            "The backup has programs and data of runs, which belong in a data folder. Restore it "
            "without SEAMARK_STORAGE_URL"
        )


def _require_key(settings: Settings, key: str) -> None:
    """Refuse a key of the environment that is not the one of the backup."""
    if _is_given(settings, "seed_key") and settings.seed_key != key:
        raise RestoreRefused(
            "SEAMARK_SEED_KEY is not the key of the backup: ranked runs would get other seeds. "
            "Set it to the key of the service that was backed up, or do not set it"
        )


def _is_given(settings: Settings, name: str) -> bool:
    """Return whether a key comes from the environment and not from the data folder."""
    return bool(getattr(settings, name)) and not (settings.data / KEY_FILES[name]).exists()


def _require_free_target(settings: Settings, *, force: bool) -> None:
    """Refuse to replace a running service and, without `force`, also one that has stopped."""
    revision, newest = _revision(settings), schema.newest_revision()
    if not force and (revision is not None or _is_used(settings.data)):
        raise RestoreRefused(
            f"There is a service in {settings.data} or in its database. Choose an empty folder "
            "and an empty database, or replace the service with --force: its accounts, runs and "
            "programs are lost then"
        )
    if revision not in (None, newest):
        raise RestoreRefused(
            f"The database that --force would replace has schema {revision}, and this version "
            f"has {newest}. Give an empty database, or run `seamark db upgrade` first"
        )


def _revision(settings: Settings) -> str | None:
    """Return the schema of the database, None if it is empty; refuse one that a worker uses."""
    file = make_url(settings.database_url).database or ""
    if settings.database_url.startswith("sqlite:") and not Path(file).exists():
        return None  # connecting would create the file
    database = Database(settings.database_url)
    try:
        with database.engine.connect() as connection:
            revision = schema.revision_of(connection)
        if revision == schema.newest_revision():
            _require_no_worker(database)
    finally:
        database.close()
    return revision


def _require_room(data: Path, needed: int) -> None:
    """Refuse a disk on which the files of the backup have no room."""
    folder = next(folder for folder in (data, *data.parents) if folder.exists())
    free = shutil.disk_usage(folder).free
    if free < needed:
        raise RestoreRefused(
            f"The backup needs about {needed / 2**20:,.0f} MiB, and {folder} has room for "
            f"{free / 2**20:,.0f} MiB"
        )


def _require_no_worker(database: Database) -> None:
    with database.reading() as session:
        alive = [worker.name for worker in workers.listed(session) if worker.alive]
    if alive:
        raise RestoreRefused(
            f"Worker {alive[0]} is running. Stop all processes of the service first; a worker that "
            f"was killed counts as running for {workers.ALIVE_S:.0f} seconds"
        )


def _is_used(data: Path) -> bool:
    marks = (storage.mark(data), data_folder.unfinished(data))
    return any(path.exists() for path in (*marks, *(data / name for name in DATA)))


def _clear(data: Path) -> None:
    storage.mark(data).unlink(missing_ok=True)
    for name in (*DATA, *DERIVED):
        if (data / name).exists():
            shutil.rmtree(data / name)


def _unpack(connection: Connection, settings: Settings, source: Path, on_bytes: OnBytes) -> Summary:
    """Fill the tables and write the files; the sums have been compared before."""
    rows, summary, deleted = Counter[str](), None, dict[str, float]()
    for member, content in archive.members(source, on_bytes):
        table, path = layout.table_of(member), layout.path_of(member, settings.data)
        if table is not None:
            rows[table] += tables.load(connection, table, content.read())
        elif path is not None:
            _write(path, content)
        elif member == layout.DELETED:
            deleted = json.loads(content.read())
        elif member == layout.SUMMARY:
            summary = Summary.model_validate_json(content.read())
    if summary is None or summary.rows != rows:
        raise ArchiveRejected(f"{source} has other rows than it says")
    tables.count_on(connection)
    for run_id, deleted_at in deleted.items():
        values = {"data_deleted_at": deleted_at, "data_bytes": 0, "data_measured": True}
        connection.execute(update(Run).where(Run.id == int(run_id)).values(values))
        retention.remove_files(settings, int(run_id))
    return summary


def _write(path: Path, content: Content) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, MODE), "wb") as file:
        file.writelines(content.parts())


def _finish(settings: Settings, keys: dict[str, str], source: Path) -> None:
    """Write the keys that the environment does not give and the mark; let services start."""
    for name, file in KEY_FILES.items():
        if not _is_given(settings, name):
            (settings.data / file).unlink(missing_ok=True)
            kept(settings.data / file, keys[file])
    database = Database(settings.database_url)
    try:
        with database.writing() as session:
            if not settings.storage_url:  # object storage keeps the mark that it has
                data_folder.mark_restored(session.connection(), settings)
            audit.record(session, COMMAND_LINE, AuditAction.BACKUP_RESTORED, source.name)
    finally:
        database.close()
    os.sync()  # a power cut must not leave the folder without the last files
    data_folder.unfinished(settings.data).unlink()
