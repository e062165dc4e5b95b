"""`seamark db`: the database."""

from __future__ import annotations

from pathlib import Path

import click

from seamark.cli.console import print_json
from seamark.cli.local_service import data_option, database_of, settings_of
from seamark.cli.options import json_option


@click.group()
def db() -> None:
    """Manage the database."""


@db.command()
@data_option
@json_option
def upgrade(data: Path | None, as_json: bool) -> None:
    """Create the tables, or upgrade them to this version. Running it again is safe.

    `seamark up` does this at its start.

    \b
    Examples:
      seamark db upgrade
      SEAMARK_DATABASE_URL=postgresql://seamark@db/seamark seamark db upgrade
    """
    from sqlalchemy.exc import SQLAlchemyError

    from seamark.failures import PlatformFailed
    from seamark.server.database import schema
    from seamark.server.database.data_folder import WrongDataFolder

    settings = settings_of(data)
    try:
        schema.upgrade(settings)
    except (SQLAlchemyError, WrongDataFolder) as error:
        raise PlatformFailed(f"The database cannot be upgraded: {error}.") from None
    url = _without_password(settings.database_url)
    if as_json:
        print_json({"database": url})
    else:
        click.echo(f"The database is up to date: {url}")


@db.command("grant-worker")
@click.argument("role")
@data_option
@json_option
def grant_worker(role: str, data: Path | None, as_json: bool) -> None:
    """Give ROLE, an existing role of PostgreSQL, the rights that a worker needs, and no others.

    Run it again after each upgrade of the database.

    \b
    Example:
      seamark db grant-worker seamark_worker
    """
    from sqlalchemy.exc import SQLAlchemyError

    from seamark.failures import PlatformFailed, UsageRefused
    from seamark.server.database import worker_role

    database = database_of(settings_of(data))
    try:
        with database.engine.begin() as connection:
            worker_role.grant(connection, role)
    except worker_role.NotPostgreSQL as error:
        raise UsageRefused(f"{error}.") from None
    except SQLAlchemyError as error:
        raise PlatformFailed(f"The rights cannot be granted: {error}.") from None
    finally:
        database.close()
    if as_json:
        print_json({"role": role})
    else:
        click.echo(f"{role} has the rights of a worker.")


@db.command()
@click.argument("revision")
@data_option
@json_option
def downgrade(revision: str, data: Path | None, as_json: bool) -> None:
    """Return the tables to the schema REVISION (such as 0031), to go back to an earlier version.

    Stop the service first. What only the later schema stores is lost: back the database up.

    \b
    Example:
      seamark db downgrade 0031
    """
    from alembic.util import CommandError
    from sqlalchemy.exc import SQLAlchemyError

    from seamark.failures import PlatformFailed, UsageRefused
    from seamark.server.database import schema

    settings = settings_of(data)
    try:
        schema.downgrade(settings, revision)
    except CommandError as error:
        raise UsageRefused(f"The database cannot be downgraded: {error}.") from None
    except SQLAlchemyError as error:
        raise PlatformFailed(f"The database cannot be downgraded: {error}.") from None
    if as_json:
        print_json({"schema": revision})
    else:
        click.echo(f"The database has the schema {revision}.")


@db.command("rebuild-leaderboard")
@data_option
@json_option
def rebuild_leaderboard(data: Path | None, as_json: bool) -> None:
    """Compute the leaderboard and the queue from the stored runs, also while the service runs.

    The service keeps both up to date by itself. This is for after changing the tables
    by hand, for example after deleting runs.

    \b
    Examples:
      seamark db rebuild-leaderboard --data data
    """
    from sqlalchemy.exc import SQLAlchemyError

    from seamark.failures import PlatformFailed
    from seamark.server.runs.leaderboard import best_runs
    from seamark.server.runs.record import turns

    database = database_of(settings_of(data))
    try:
        with database.writing() as session:
            count = best_runs.rebuild(session)
            turns.rebuild(session)
    except SQLAlchemyError as error:
        raise PlatformFailed(f"The leaderboard cannot be rebuilt: {error}.") from None
    finally:
        database.close()
    if as_json:
        print_json({"entries": count})
    else:
        click.echo(f"The leaderboard is rebuilt: {count} {'entry' if count == 1 else 'entries'}.")


@db.command("reference-entries")
@data_option
@json_option
def reference_entries(data: Path | None, as_json: bool) -> None:
    """Queue the runs of the reference entries that are missing. Running it again is safe.

    They are on every leaderboard: built-in controllers and trackers, evaluated by this service.
    `seamark up` does this at its start.

    \b
    Example:
      seamark db upgrade && seamark db reference-entries
    """
    from sqlalchemy.exc import SQLAlchemyError

    from seamark.failures import PlatformFailed
    from seamark.server.monitoring import log
    from seamark.server.runs.submission import baselines

    settings = settings_of(data)
    log.configure(settings.log_level)
    database = database_of(settings)
    try:
        with database.writing() as session:
            queued = baselines.ensure(session, settings)
    except SQLAlchemyError as error:
        raise PlatformFailed(f"The reference entries cannot be queued: {error}.") from None
    finally:
        database.close()
    if as_json:
        print_json({"runs": queued})
    else:
        click.echo(f"{len(queued)} {'run' if len(queued) == 1 else 'runs'} queued.")


def _without_password(url: str) -> str:
    from sqlalchemy import make_url

    return make_url(url).render_as_string(hide_password=True)
