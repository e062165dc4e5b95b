"""`seamark backup` and `seamark restore`: the whole service in one file."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import click

from seamark.cli.console import print_json
from seamark.cli.local_service import data_option, settings_of
from seamark.cli.options import json_option
from seamark.failures import PlatformFailed, UsageRefused
from seamark.progress import Progress

if TYPE_CHECKING:
    from seamark.server.administration.backup.creation import Backup
    from seamark.server.administration.backup.layout import Header, Summary
    from seamark.server.database.engine import Database
    from seamark.server.settings import Settings

KEYS_NOTE = (
    "It has the keys and the hashes of passwords and tokens of the service: keep it as safe as "
    "the data folder."
)


@click.command()
@click.argument("target", metavar="FILE|FOLDER", type=click.Path(path_type=Path))
@data_option
@json_option
def backup(target: Path, data: Path | None, as_json: bool) -> None:
    """Write a backup of the whole service into one new file, while the service runs.

    In a FOLDER the file is called seamark-DATE-TIME.tar. It has the database, the keys, the
    programs and the data of all runs that have ended; queued and running ones start again after
    `seamark restore`. It can be restored with SQLite and with PostgreSQL, whichever it was.

    \b
    Examples:
      seamark backup /mnt/backups
      seamark backup before-update.tar --data /var/lib/seamark
    """
    from seamark.server.administration.backup import creation

    settings = settings_of(data)
    if target.is_dir():
        target /= f"seamark-{datetime.now(UTC):%Y%m%d-%H%M%S}.tar"
    if not target.parent.is_dir():
        raise UsageRefused(f"There is no folder {target.parent}.")
    database = _unchanged_database(settings)
    try:
        needed = creation.estimated_bytes(database, settings)
        creation.refuse_without_room(settings, target, needed)
        with Progress("Backup", quiet=as_json) as progress:
            made = creation.make(database, settings, target, _shown(progress, needed))
        _record(database, made)
    except creation.BackupFailed as error:
        raise PlatformFailed(str(error)) from None
    finally:
        database.close()
    _say_made(made, as_json=as_json)


@click.command()
@click.argument(
    "source", metavar="FILE", type=click.Path(exists=True, dir_okay=False, path_type=Path)
)
@click.option("--check", is_flag=True, help="Only verify the backup; change nothing.")
@click.option("--force", is_flag=True, help="Replace the service that is there.")
@data_option
@json_option
def restore(*, source: Path, check: bool, force: bool, data: Path | None, as_json: bool) -> None:
    """Restore the service from a backup, into an empty data folder and an empty database.

    The whole backup is verified first. Everything is as it was when the backup began: queued runs
    go on, those that were running start again.

    \b
    Examples:
      seamark restore seamark-20261122-210000.tar --check
      seamark restore seamark-20261122-210000.tar --data /var/lib/seamark
    """
    from sqlalchemy.exc import SQLAlchemyError

    from seamark.embedded.service import locked
    from seamark.server.administration.backup import restoring
    from seamark.server.administration.backup.archive import ArchiveRejected

    size = source.stat().st_size
    try:
        if check:
            with Progress("Check", quiet=as_json) as progress:
                header = restoring.check(source, _shown(progress, size))
            return _say_checked(source, header, as_json=as_json)
        settings = settings_of(data, looking=True)
        with Progress("Restore", quiet=as_json) as progress:
            shown = _shown(progress, 2 * size)
            summary = restoring.restore(
                settings, source, force=force, on_bytes=shown, locked=locked
            )
    except (ArchiveRejected, restoring.RestoreRefused) as error:
        raise UsageRefused(f"{error}.") from None
    except (OSError, SQLAlchemyError) as error:
        raise PlatformFailed(f"The backup cannot be restored: {error}.") from None
    _say_restored(summary, settings, as_json=as_json)


def _unchanged_database(settings: Settings) -> Database:
    """Return the database of a service; refuses one that this version would have to upgrade."""
    from sqlalchemy.exc import SQLAlchemyError

    from seamark.cli.local_service import refuse_without_service
    from seamark.server.database import schema
    from seamark.server.database.engine import Database

    refuse_without_service(settings)
    # Its snapshot keeps nobody waiting, however slow the disk is that the backup is written to.
    database = Database(settings.database_url, idle_s=0.0)
    try:
        schema.check(database.engine)
    except schema.SchemaTooOld as error:
        database.close()
        raise UsageRefused(
            f"Back up with the version that the service has, before it is updated: {error}."
        ) from None
    except SQLAlchemyError as error:
        raise PlatformFailed(f"The database does not answer: {error}.") from None
    return database


def _record(database: Database, made: Backup) -> None:
    from seamark.server.accounts import audit
    from seamark.server.accounts.audit import COMMAND_LINE, AuditAction

    detail = {"bytes": made.bytes, "runs": made.summary.rows.get("runs", 0)}
    with database.writing() as session:
        audit.record(session, COMMAND_LINE, AuditAction.BACKUP_MADE, made.path.name, detail)


def _shown(progress: Progress, total: int) -> Callable[[int], None]:
    """Return what is told how many more bytes are done."""
    done = 0

    def show(more: int) -> None:
        nonlocal done
        done += more
        progress.show(min(done / total, 0.999) if total else 0.0)

    return show


def _say_made(made: Backup, *, as_json: bool) -> None:
    if as_json:
        counts = made.summary.model_dump()
        print_json({"file": str(made.path), "size": made.bytes, **counts})
        return
    _say(f"{made.path} ({made.bytes / 2**20:.1f} MiB)", made.summary)
    click.echo(KEYS_NOTE)


def _say_checked(source: Path, header: Header, *, as_json: bool) -> None:
    if as_json:
        print_json({"file": str(source), "complete": True, **header.model_dump()})
        return
    made_at = datetime.fromtimestamp(header.made_at, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    click.echo(f"{source} is complete. Made by Seamark {header.version} at {made_at}.")


def _say_restored(summary: Summary, settings: Settings, *, as_json: bool) -> None:
    if as_json:
        print_json({"data": str(settings.data), **summary.model_dump()})
        return
    _say(f"Restored in {settings.data}", summary)
    click.echo("Start the service: queued runs go on, those that were running start again.")


def _say(first: str, summary: Summary) -> None:
    rows = summary.rows
    counts = (
        _counted(rows.get("users", 0), "account"),
        f"{_counted(rows.get('runs', 0), 'run')} ({summary.runs_with_data:,} with data)",
        _counted(summary.programs, "program"),
    )
    click.echo(f"{first}: {', '.join(counts)}.")


def _counted(number: int, what: str) -> str:
    return f"{number:,} {what}{'' if number == 1 else 's'}"
