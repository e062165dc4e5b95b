"""The service whose data folder a command selects with --data: its settings and its database."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from seamark.cli.options import Command
from seamark.failures import PlatformFailed, UsageRefused

if TYPE_CHECKING:
    from seamark.server.database.engine import Database
    from seamark.server.settings import Settings

OF_CLIENTS = frozenset({"SEAMARK_SERVER", "SEAMARK_TOKEN"})  # no settings of a service


def data_option(command: Command) -> Command:
    """Add --data."""
    return click.option(
        "--data",
        type=click.Path(file_okay=False, path_type=Path),
        metavar="DIR",
        help="Data folder of the service.  [default: $SEAMARK_DATA or ./data]",
    )(command)


def settings_of(data: Path | None, *, looking: bool = False, **chosen: object) -> Settings:
    """Return the settings of the environment, overridden by options of the command line.

    Parameters
    ----------
    looking
        Make neither a data folder nor keys where there are none.
    """
    from seamark.server.settings import PREFIX, Settings, SettingsInvalid

    environ = {key: value for key, value in os.environ.items() if key not in OF_CLIENTS}
    overrides: Mapping[str, object] = {"data": data, **chosen}
    for name, value in overrides.items():
        if value is not None:
            environ.pop(f"{PREFIX}{name.upper()}_FILE", None)
            environ[PREFIX + name.upper()] = str(value)
    try:
        return Settings.load(environ, looking=looking)
    except SettingsInvalid as error:
        raise UsageRefused(f"{error}.") from None
    except OSError as error:
        raise UsageRefused(
            f"The data folder {error.filename} cannot be used: {error.strerror}. "
            "Choose another one with --data."
        ) from None


def refuse_without_service(settings: Settings) -> None:
    """Refuse a data folder in which there is no database, where that is SQLite."""
    sqlite = "sqlite:///"
    file = Path(settings.database_url.removeprefix(sqlite))
    if settings.database_url.startswith(sqlite) and not file.exists():
        raise UsageRefused(
            f"There is no service in {settings.data}. Name its folder with --data or SEAMARK_DATA; "
            "with Docker Compose, run `docker compose exec -T web seamark ...`."
        )


def existing_database_of(settings: Settings) -> Database:
    """Return the database of a service; refuses to make one, which no service would ever read."""
    refuse_without_service(settings)
    return database_of(settings)


def database_of(settings: Settings) -> Database:
    """Return the database, upgraded to the tables of this version if they are older."""
    from sqlalchemy.exc import SQLAlchemyError

    from seamark.server.database import schema
    from seamark.server.database.engine import Database

    database = Database(settings.database_url)
    try:
        schema.check(database.engine)
    except schema.SchemaTooOld:
        schema.upgrade(settings)
    except SQLAlchemyError as error:
        raise PlatformFailed(f"The database does not answer: {error}.") from None
    return database
