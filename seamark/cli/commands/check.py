"""`seamark check`: the errors of a program, found without a server."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from seamark.cli.console import exit_with, print_json
from seamark.cli.options import configuration_options, json_option
from seamark.sim.registry import DEFAULT_BENCHMARK

if TYPE_CHECKING:
    from seamark.programs.preparation import PreparedProgram

SHOWN_OUTPUT = 2000  # [characters]


@click.command()
@click.argument("file", type=click.Path(path_type=Path), metavar="FILE|FOLDER")
@click.option("--benchmark", default=DEFAULT_BENCHMARK, show_default=True)
@configuration_options
@json_option
def check(
    *,
    file: Path,
    benchmark: str,
    pairs: tuple[str, ...],
    config: Path | None,
    as_json: bool,
) -> None:
    """Compile and start a program, and run two simulated seconds with it in the sandbox.

    Reports errors with their lines. Exit code 0: the program runs; 1: it has errors.

    \b
    Examples:
      seamark check my_controller.py
      seamark check my_controller.zip --set vehicle=girona500-uwsim
      seamark check controller.c --json
      seamark check my_arm/ --benchmark recover-v1
    """
    from seamark.cli.configuration import run_configuration_of
    from seamark.cli.extras import absent_in_box
    from seamark.cli.solutions import file_of, prepare
    from seamark.programs import check_report

    prepared = prepare(file_of(file), benchmark=benchmark)
    values = run_configuration_of(benchmark, config, pairs, prepared)
    if prepared.diagnostics:
        checked = check_report.from_diagnostics(prepared.diagnostics)
    else:
        checked = _run(benchmark, values, prepared)
    if as_json:
        print_json({"program_name": prepared.name, "language": prepared.language, **checked})
    else:
        _report(file, checked)
    if install := absent_in_box(" ".join(problem["sentence"] for problem in checked["problems"])):
        click.echo(install, err=True)
    exit_with(0 if checked["ok"] else 1)


def _run(benchmark: str, values: dict[str, Any], prepared: PreparedProgram) -> dict[str, Any]:
    from seamark.cli.simulator_loading import compiling_said
    from seamark.cli.solutions import isolation_level, sandbox_failures_explained
    from seamark.worker.evaluation.local import check_locally

    with sandbox_failures_explained(), compiling_said(partial(click.echo, err=True)):
        return check_locally(benchmark, values, prepared, isolation=isolation_level())


def _report(file: Path, checked: dict[str, Any]) -> None:
    from seamark.programs.diagnostics import Diagnostic

    for problem in checked["problems"]:
        click.echo(Diagnostic(**problem).text())
    if checked["traceback"] and not any(p["stage"] == "compile" for p in checked["problems"]):
        click.echo(checked["traceback"].rstrip())
    if checked["output"]:
        click.echo(f"Output:\n{checked['output'][-SHOWN_OUTPUT:].rstrip()}")
    if checked["ok"]:
        count = checked["step_us"]["count"] if checked["step_us"] else 0
        used = checked["usage"] or {"cpu_s": 0.0, "memory_mib": 0.0}
        cost = f"{used['cpu_s']:.2f} s of CPU time, {used['memory_mib']:.0f} MiB"
        click.echo(f"{file.name} runs: {count} steps, {cost}.")
