"""Making a backup while the service runs.

1. The rows of all tables, in one transaction that reads: the backup is the state of that moment.
2. All programs, and the files of the runs that had ended by then: those do not change any more. Of
   queued and running runs there is nothing to copy, they start again. What is in object storage
   stays there.
3. The runs whose data were deleted meanwhile, so that no row promises data that are gone.
"""

import json
import shutil
import time
from array import array
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from sqlalchemy import Connection, select

from seamark.server.administration.backup import archive, layout, tables
from seamark.server.administration.backup.archive import ArchiveWriter, OnBytes
from seamark.server.administration.backup.layout import Header, Summary
from seamark.server.database import schema
from seamark.server.database.engine import Database, size_bytes
from seamark.server.database.tables import Run
from seamark.server.programs import store
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.record.states import FINAL
from seamark.server.settings import Settings
from seamark.server.storage import storage

CLOCKS_S = 3600.0  # by which the clocks of machines that delete data may differ
_DRAFT = "."  # what a file that is being written starts with


class BackupFailed(Exception):
    """No backup was made. The text says why and what to do."""


@dataclass(frozen=True, slots=True)
class Backup:
    """A backup that was made."""

    path: Path
    bytes: int
    summary: Summary


def make(database: Database, settings: Settings, target: Path, on_bytes: OnBytes) -> Backup:
    """Write a backup into the new file `target`.

    Raises
    ------
    BackupFailed
        The data folder is away, there is such a file, or there is no room for it.
    """
    if storage.is_away(settings):
        raise BackupFailed(f"The data folder {settings.data} is away or not permitted.")
    try:
        with archive.writing(target, on_bytes) as writer:
            summary = _write(writer, database, settings)
    except FileExistsError:
        raise BackupFailed(f"{target} exists. Choose another name.") from None
    except OSError as error:
        raise BackupFailed(f"{error.filename or target}: {error.strerror or error}.") from None
    return Backup(target, target.stat().st_size, summary)


def estimated_bytes(database: Database, settings: Settings) -> int:
    """Return about how large a backup will be: what there is to copy now [B]."""
    with database.reading() as session:
        connection = session.connection()
        of_database = size_bytes(connection)
        ended = array("q") if settings.storage_url else _ended_runs(connection)
    of_runs = sum(RunFiles(settings.data, run_id).size() for run_id in ended)
    of_programs = sum(store.size(settings, path.name) for path in _programs(settings.data))
    return of_database + of_runs + of_programs


def refuse_without_room(settings: Settings, target: Path, needed: int) -> None:
    """Raise BackupFailed unless a backup fits, and leaves a service on the same disk its room."""
    folder = target.parent
    same_disk = folder.stat().st_dev == settings.data.stat().st_dev
    free = shutil.disk_usage(folder).free - (settings.free_min_bytes if same_disk else 0)
    if free < needed:
        raise BackupFailed(
            f"The backup needs about {_size(needed)}, and {folder} has room for "
            f"{_size(max(free, 0))}"
            + (" besides what the service needs (SEAMARK_FREE_MIN_BYTES)." if same_disk else ".")
        )


def _write(writer: ArchiveWriter, database: Database, settings: Settings) -> Summary:
    with database.reading() as session:
        connection = session.connection()
        made_at, rows = time.time(), Counter[str]()
        header = Header(
            format=layout.FORMAT,
            version=version("seamark"),
            schema_revision=schema.revision_of(connection) or "",
            made_at=made_at,
            objects=bool(settings.storage_url),
        )
        writer.add_bytes(layout.HEADER, header.model_dump_json(indent=2).encode())
        for name, key in zip(layout.KEYS, (settings.seed_key, settings.secret_key), strict=True):
            writer.add_bytes(layout.of_key(name), key.encode())
        for number, (table, count, chunk) in enumerate(tables.dump(connection)):
            writer.add_bytes(layout.of_chunk(table, number), chunk)
            rows[table] += count
        ended = array("q") if settings.storage_url else _ended_runs(connection)
    programs = _add_programs(writer, settings.data)
    runs = _add_runs(writer, database, settings.data, ended, since=made_at - CLOCKS_S)
    summary = Summary(rows=rows, runs_with_data=runs, programs=programs, bytes=writer.bytes)
    writer.add_bytes(layout.SUMMARY, summary.model_dump_json(indent=2).encode())
    return summary


def _add_programs(writer: ArchiveWriter, data: Path) -> int:
    count = 0
    for path in _programs(data):
        try:
            writer.add_file(layout.of_program(path.name), path)
            count += 1
        except FileNotFoundError:  # unused, and deleted since the folder was listed
            continue
    return count


def _add_runs(
    writer: ArchiveWriter, database: Database, data: Path, ended: Collection[int], *, since: float
) -> int:
    """Add the files of these runs, and which of the runs have lost them meanwhile."""
    count, vanished = 0, set[int]()
    for run_id in ended:
        try:
            count += _add_run(writer, RunFiles(data, run_id))
        except FileNotFoundError:
            vanished.add(run_id)
    deleted = _deleted_since(database, since)
    if unexplained := vanished - deleted.keys():
        raise BackupFailed(
            f"Files of run {min(unexplained)} vanished while they were copied, and the service "
            "did not delete them. Find out what did, then start again."
        )
    copied = {str(run_id): deleted[run_id] for run_id in ended if run_id in deleted}
    writer.add_bytes(layout.DELETED, json.dumps(copied).encode())
    return count


def _add_run(writer: ArchiveWriter, files: RunFiles) -> bool:
    """Add the files of the last attempt of a run; False if there are none."""
    if not files.folder.is_dir():
        return False
    run_id, names = int(files.root.name), sorted(entry.name for entry in files.folder.iterdir())
    for name in names:
        if not name.startswith(_DRAFT):
            member = layout.of_run_file(run_id, files.attempt, name)
            writer.add_file(member, files.folder / name)
    return True


def _ended_runs(connection: Connection) -> "array[int]":
    """Return the runs that have data which do not change any more."""
    query = select(Run.id).where(Run.state.in_(FINAL), Run.data_deleted_at.is_(None))
    rows = connection.execute(query.order_by(Run.id), execution_options={"yield_per": 10_000})
    return array("q", rows.scalars())


def _deleted_since(database: Database, moment: float) -> dict[int, float]:
    """Return the runs whose data were deleted after a moment, and when."""
    query = select(Run.id, Run.data_deleted_at).where(Run.data_deleted_at > moment)
    with database.reading() as session:
        return {run_id: at for run_id, at in session.execute(query) if at is not None}


def _programs(data: Path) -> Iterator[Path]:
    for path in (data / "programs").glob("*"):
        if layout.path_of(layout.of_program(path.name), data) is not None:
            yield path


def _size(number: int) -> str:
    return f"{number / 2**30:.1f} GiB" if number >= 2**30 else f"{number / 2**20:.1f} MiB"
