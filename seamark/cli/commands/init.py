"""`seamark init`: a starter program in any of the languages."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from seamark.cli.console import print_json
from seamark.cli.options import json_option
from seamark.drafts import replace_file
from seamark.failures import UsageRefused
from seamark.sandbox.languages import DEFAULT_LANGUAGE, starters
from seamark.sim.registry import DEFAULT_BENCHMARK

if TYPE_CHECKING:
    from seamark.sandbox.languages.sample import Sample
    from seamark.sim.benchmarks.benchmark import Benchmark


@click.command()
@click.option(
    "--language", type=click.Choice(tuple(starters())), default=DEFAULT_LANGUAGE, show_default=True
)
@click.option(
    "--benchmark",
    default=DEFAULT_BENCHMARK,
    show_default=True,
    help="The benchmark it is for; visibility-v3 compares trackers, recover-v1 moves an arm.",
)
@click.argument("folder", type=click.Path(path_type=Path), metavar="[DIR]", default=".")
@json_option
def init(*, language: str, benchmark: str, folder: Path, as_json: bool) -> None:
    """Write a starter program to DIR; it runs as it is.

    C and C++ come with the header seamark.h for your editor; the sandbox uses its own. An FMU
    comes with its sources: it is a zip archive of them. An executable can be written in any
    language that speaks the protocol of docs/protocol.md; the starter is in C, and you compile it.
    Beside a program that moves an arm is a file with the kinematics of all arms, in Python, C, C++
    and MATLAB.

    \b
    Examples:
      seamark init
      seamark init --language c++ my_controller
      seamark init --benchmark visibility-v3 my_tracker
      seamark init --benchmark recover-v1 my_arm
    """
    from seamark.cli.configuration import benchmark_of

    entry = benchmark_of(benchmark)
    starter, files = _started(entry, language)
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
    quick = entry.quick_settings.items()
    settings = " ".join(f"--set {key}={_text(value)}" for key, value in quick)
    commands.append(f"seamark run {benchmark} --controller {main} {settings}")
    written = [str(folder / name) for name in files]
    if as_json:
        print_json({"files": written, "try": commands})
        return
    click.echo(f"Wrote {', '.join(written)}. Try it:")
    for command in commands:
        click.echo(f"  {command}")


def _started(benchmark: Benchmark, language: str) -> tuple[Sample, dict[str, bytes]]:
    """Return the program to start from and the files that are written for it, the main one first.

    Raises
    ------
    UsageRefused
        There is none in this language.
    """
    role, moves_arm = benchmark.role, benchmark.moves_arm
    known = starters(role, moves_arm=moves_arm)
    if language not in known:
        names = ", ".join(known)
        raise UsageRefused(f"There is a {role} to start from in {names}, not in {language}.")
    files = known[language].contents()
    if not moves_arm:
        return known[language], files
    from seamark.programs.arm_helpers import helper

    return known[language], files | helper(language)


def _text(value: object) -> str:
    return ",".join(map(str, value)) if isinstance(value, list) else str(value)
