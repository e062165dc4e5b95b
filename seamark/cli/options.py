"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import click
from click.shell_completion import CompletionItem

from seamark.cli.extras import has_simulator

Command = TypeVar("Command", bound=Callable[..., Any])
PARTS = ("tracker", "detector")  # roles of further programs in a run


def benchmark_argument(command: Command) -> Command:
    """Add BENCHMARK, which shells complete."""
    return click.argument("benchmark", shell_complete=_benchmarks)(command)


def controller_option(command: Command) -> Command:
    """Add --controller; shells complete built-in solutions and files."""
    return click.option(
        "--controller",
        metavar="FILE|FOLDER|NAME",
        help="A file, a folder of them, or a built-in solution.  [default: the benchmark's first]",
        shell_complete=_solutions,
    )(command)


def part_options(command: Command) -> Command:
    """Add an option for the program of each role that a benchmark may have beside its own."""
    for role in reversed(PARTS):
        command = click.option(
            f"--{role}-program",
            type=click.Path(path_type=Path),
            metavar="FILE|FOLDER",
            help=f"A {role} of your own, where the benchmark has one beside the controller, in "
            f"place of the built-in {role} that the settings choose.",
        )(command)
    return command


def parts_in(options: Mapping[str, Path | None]) -> dict[str, Path]:
    """Return role -> file of the options that `part_options` added."""
    given = {role: options[f"{role}_program"] for role in PARTS}
    return {role: path for role, path in given.items() if path is not None}


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
    items = [CompletionItem(name) for name in sorted(names) if name.startswith(incomplete)]
    return items or [CompletionItem(incomplete, type="file")]


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
