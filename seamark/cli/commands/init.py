"""`seamark init`: a starter program in any of the languages."""

from __future__ import annotations

from pathlib import Path

import click

from seamark.cli.console import print_json
from seamark.cli.options import json_option
from seamark.drafts import replace_file
from seamark.failures import UsageRefused
from seamark.sandbox.languages import DEFAULT_LANGUAGE, starters
from seamark.sim.registry import DEFAULT_BENCHMARK


@click.command()
@click.option(
    "--language", type=click.Choice(tuple(starters())), default=DEFAULT_LANGUAGE, show_default=True
)
@click.option(
    "--benchmark",
    default=DEFAULT_BENCHMARK,
    show_default=True,
    help="The benchmark it is for; visibility-v2 compares trackers.",
)
@click.argument("folder", type=click.Path(path_type=Path), metavar="[DIR]", default=".")
@json_option
def init(*, language: str, benchmark: str, folder: Path, as_json: bool) -> None:
    """Write a starter program to DIR; it runs as it is.

    C and C++ come with the header seamark.h for your editor; the sandbox uses its own. An FMU
    comes with its sources: it is a zip archive of them. An executable can be written in any
    language that speaks the protocol of docs/protocol.md; the starter is in C, and you compile it.

    \b
    Examples:
      seamark init
      seamark init --language c++ my_controller
      seamark init --benchmark visibility-v2 my_tracker
    """
    from seamark.cli.configuration import benchmark_of

    entry = benchmark_of(benchmark)
    role, short = entry.role, entry.quick_settings
    starter = starters(role).get(language)
    if starter is None:
        names = ", ".join(starters(role))
        raise UsageRefused(f"There is a {role} to start from in {names}, not in {language}.")
    files = starter.contents()
    taken = [name for name in files if (folder / name).exists()]
    if taken:
        raise UsageRefused(f"{folder / taken[0]} already exists; nothing was written.")
    try:
        for name, content in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            replace_file(folder / name, content)
    except OSError as error:
        raise UsageRefused(f"{folder} cannot be written: {error.strerror}.") from None
    main, commands = folder / next(iter(files)), []
    if starter.build:
        source, main = main, main.with_suffix(".elf")
        commands.append(starter.build.format(source=source, program=main))
    quick = " ".join(f"--set {key}={_text(value)}" for key, value in short.items())
    commands.append(f"seamark run {benchmark} --controller {main} {quick}")
    written = [str(folder / name) for name in files]
    if as_json:
        print_json({"files": written, "try": commands})
        return
    click.echo(f"Wrote {', '.join(written)}. Try it:")
    for command in commands:
        click.echo(f"  {command}")


def _text(value: object) -> str:
    return ",".join(map(str, value)) if isinstance(value, list) else str(value)
