"""Options that several commands share, and what they mean."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

import click

from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from seamark.server.database.engine import Database
    from seamark.server.settings import Settings

Command = TypeVar("Command", bound=Callable[..., Any])


def data_option(command: Command) -> Command:
    """Add --data."""
    return click.option(
        "--data",
        type=click.Path(file_okay=False, path_type=Path),
        metavar="DIR",
        help="Folder of the embedded service.  [default: $SEAMARK_DATA or ./data]",
    )(command)


def server_options(command: Command) -> Command:
    """Add --server and --token."""
    command = click.option(
        "--token",
        metavar="T",
        envvar="SEAMARK_TOKEN",
        help="Token of your account; made on the account page or with `seamark token new`.",
    )(command)
    return click.option(
        "--server",
        metavar="URL",
        default="http://127.0.0.1:8000",
        show_default=True,
        help="Address of the service.",
    )(command)


def json_option(command: Command) -> Command:
    """Add --json."""
    return click.option(
        "--json", "as_json", is_flag=True, help="Answer with one JSON object for programs."
    )(command)


def order_options(command: Command) -> Command:
    """Add what says which controller is to be evaluated how: five options and their limits."""
    from seamark.sim.engine.seeds import SEED_MAX

    for option in reversed(
        (
            click.option(
                "--controller",
                metavar="FILE|NAME",
                help="A program, or what is built in.  [default: the benchmark's first]",
            ),
            configuration_options,
            click.option("--seed", type=click.IntRange(0, SEED_MAX), help="Else drawn, and shown."),
            click.option(
                "--trials",
                type=click.IntRange(1, 100),
                default=1,
                show_default=True,
                help="Here they run side by side, one per core; the bytes are the same.",
            ),
        )
    ):
        command = option(command)
    return command


def configuration_options(command: Command) -> Command:
    """Add --set and --config."""
    command = click.option(
        "--config",
        type=click.Path(dir_okay=False, path_type=Path),
        help="TOML or JSON with the keys of the schema; --set wins.",
    )(command)
    return click.option(
        "--set", "pairs", metavar="KEY=VALUE", multiple=True, help="May be repeated."
    )(command)


def settings_of(data: Path | None, **chosen: object) -> Settings:
    """Return the settings of the environment with the options of the command line on top."""
    from seamark.server.settings import PREFIX, Settings, SettingsInvalid

    environ = {key: value for key, value in os.environ.items() if key != "SEAMARK_TOKEN"}
    given: Mapping[str, object] = {"data": data, **chosen}
    for name, value in given.items():
        if value is not None:
            environ.pop(f"{PREFIX}{name.upper()}_FILE", None)
            environ[PREFIX + name.upper()] = str(value)
    try:
        return Settings.load(environ)
    except SettingsInvalid as wrong:
        raise UsageRefused(f"{wrong}.") from None
    except OSError as error:
        raise UsageRefused(
            f"The data folder {error.filename} cannot be used: {error.strerror}. "
            "Choose another with --data."
        ) from None


def database_of(settings: Settings) -> Database:
    """Return the database after a look whether it has this version's tables."""
    from sqlalchemy.exc import SQLAlchemyError

    from seamark.failures import PlatformFailed
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


def say(text: str) -> None:
    """Print one line for a person."""
    click.echo(text)


def answer(value: object) -> None:
    """Print one JSON object for a program."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))


def end(code: int) -> NoReturn:
    """End the command with an exit code."""
    sys.stdout.flush()
    raise click.exceptions.Exit(code)
