"""`seamark check`: what is wrong with a program, before it is submitted; no server."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from seamark.cli.options import answer, configuration_options, end, json_option, say
from seamark.failures import PlatformFailed

if TYPE_CHECKING:
    from seamark.server.programs.store import PreparedProgram

SHOWN_OUTPUT = 2000  # [character]


@click.command()
@click.argument("file", type=click.Path(path_type=Path), metavar="FILE")
@click.option("--benchmark", default="currents-v1", show_default=True)
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
    """Read, compile and start a program, and simulate two seconds with it in its sandbox.

    Names what is missing or wrong, with lines. Exit code 0: it may be submitted; 1: it may not.

    \b
    Examples:
      seamark check my_controller.py
      seamark check my_controller.zip --set vehicle=girona500-uwsim
      seamark check controller.c --json
    """
    from seamark.cli.controllers import configuration_of
    from seamark.cli.programs import prepared_of
    from seamark.server.checks import report

    values = configuration_of(benchmark, config, pairs).model_dump(mode="json")
    prepared = prepared_of(file, benchmark=benchmark)
    if prepared.diagnostics:
        found = report.from_diagnostics(prepared.diagnostics)
    else:
        found = _run(benchmark, values, prepared)
    if as_json:
        answer({"program_name": prepared.name, "language": prepared.language, **found})
    else:
        _report(file, found)
    end(0 if found["ok"] else 1)


def _run(benchmark: str, values: dict[str, Any], prepared: PreparedProgram) -> dict[str, Any]:
    from seamark.cli.programs import isolation_level
    from seamark.sandbox.outcome import SandboxBroken
    from seamark.worker.evaluation.local import check_locally

    try:
        return check_locally(benchmark, values, prepared, isolation=isolation_level())
    except SandboxBroken as broken:
        raise PlatformFailed(
            f"The sandbox failed: {broken}. `seamark doctor` says what this machine can do."
        ) from None


def _report(file: Path, found: dict[str, Any]) -> None:
    from seamark.server.programs.diagnostics import Diagnostic

    for problem in found["problems"]:
        say(Diagnostic(**problem).text())
    if found["traceback"] and not any(p["stage"] == "compile" for p in found["problems"]):
        say(found["traceback"].rstrip())
    if found["output"]:
        say(f"It printed:\n{found['output'][-SHOWN_OUTPUT:].rstrip()}")
    if found["ok"]:
        count = found["step_us"]["count"] if found["step_us"] else 0
        used = found["usage"] or {"cpu_s": 0.0, "memory_mib": 0.0}
        cost = f"{used['cpu_s']:.2f} s of CPU time, {used['memory_mib']:.0f} MiB"
        say(f"{file.name} runs: {count} steps, {cost}.")
