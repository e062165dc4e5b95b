"""Options that several commands share, and the settings and database that they select."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.shell_completion import CompletionItem

from seamark.cli.extras import has_simulator
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from seamark.server.database.engine import Database
    from seamark.server.settings import Settings

OF_CLIENTS = frozenset({"SEAMARK_SERVER", "SEAMARK_TOKEN"})  # no settings of a service

Command = TypeVar("Command", bound=Callable[..., Any])


def benchmark_argument(command: Command) -> Command:
    """Add BENCHMARK, which shells complete."""
    return click.argument("benchmark", shell_complete=_benchmarks)(command)


def controller_option(command: Command) -> Command:
    """Add --controller; shells complete built-in solutions and files."""
    return click.option(
        "--controller",
        metavar="FILE|NAME",
        help="A file or a built-in solution.  [default: the benchmark's first]",
        shell_complete=_solutions,
    )(command)


def _benchmarks(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    if not has_simulator():
        return []
    from seamark.sim.registry import BENCHMARKS

    return [CompletionItem(name) for name in BENCHMARKS if name.startswith(incomplete)]


def _solutions(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the built-in solutions of all benchmarks: click does not say which one was given."""
    if not has_simulator():
        return [CompletionItem(incomplete, type="file")]
    from seamark.sim import registry

    names = {name for one in registry.BENCHMARKS for name in registry.benchmark(one).built_in}
    found = [CompletionItem(name) for name in sorted(names) if name.startswith(incomplete)]
    return found or [CompletionItem(incomplete, type="file")]


def data_option(command: Command) -> Command:
    """Add --data."""
    return click.option(
        "--data",
        type=click.Path(file_okay=False, path_type=Path),
        metavar="DIR",
        help="Data folder of the service.  [default: $SEAMARK_DATA or ./data]",
    )(command)


def server_options(command: Command) -> Command:
    """Add --server and --token."""
    return click.option(
        "--server",
        metavar="URL",
        envvar="SEAMARK_SERVER",
        default="http://127.0.0.1:8000",
        show_default=True,
        show_envvar=True,
        help="Address of the server.",
    )(token_option(command))


def token_option(command: Command) -> Command:
    """Add --token."""
    return click.option(
        "--token",
        metavar="T",
        envvar="SEAMARK_TOKEN",
        show_envvar=True,
        help="API token of your account; see the account page or `seamark token new`.",
    )(command)


def json_option(command: Command) -> Command:
    """Add --json."""
    return click.option("--json", "as_json", is_flag=True, help="Print JSON for a program.")(
        command
    )


def run_options(command: Command) -> Command:
    """Add the options that describe a run: --controller, --set, --config, --seed, --trials."""
    return controller_option(configuration_options(_repetition_options(command)))


def bridged_run_options(command: Command) -> Command:
    """Add the options of a run whose controller is connected: --set to --trials, and --out."""
    folder = click.Path(path_type=Path)
    command = click.option("--out", type=folder, metavar="DIR", help="Folder for the data.")(
        command
    )
    return configuration_options(_repetition_options(command))


def _repetition_options(command: Command) -> Command:
    """Add --seed and --trials."""
    command = click.option(
        "--trials",
        type=click.IntRange(1, 100),
        help="Number of trials; `seamark run` evaluates one per core at a time.  [default: 1]",
    )(command)
    return click.option(
        "--seed", type=click.IntRange(0, _seed_max()), help="Random seed.  [default: random]"
    )(command)


def _seed_max() -> int | None:
    """Return the largest seed, which only a server knows where there is no simulator."""
    if not has_simulator():
        return None
    from seamark.sim.engine.seeds import SEED_MAX

    return SEED_MAX


def configuration_options(command: Command) -> Command:
    """Add --set and --config."""
    command = click.option(
        "--config",
        type=click.Path(dir_okay=False, path_type=Path),
        help="TOML or JSON file with settings; --set takes precedence.",
    )(command)
    return click.option(
        "--set", "pairs", metavar="KEY=VALUE", multiple=True, help="Set one setting; repeatable."
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
