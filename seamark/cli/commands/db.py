"""`seamark db`: the database."""

from __future__ import annotations

from pathlib import Path

import click

from seamark.cli.options import data_option, settings_of


@click.group()
def db() -> None:
    """Manage the database."""


@db.command()
@data_option
def upgrade(data: Path | None) -> None:
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

    settings = settings_of(data)
    try:
        schema.upgrade(settings)
    except SQLAlchemyError as error:
        raise PlatformFailed(f"The database cannot be upgraded: {error}.") from None
    click.echo(f"The database is up to date: {_without_password(settings.database_url)}")


def _without_password(url: str) -> str:
    from sqlalchemy import make_url

    return make_url(url).render_as_string(hide_password=True)
