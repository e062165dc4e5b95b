"""`seamark run`: evaluate a controller here, with the same bytes as on a server."""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from seamark.cli.console import INTERRUPTED, exit_with, print_json
from seamark.cli.options import (
    benchmark_argument,
    json_option,
    part_options,
    parts_in,
    run_options,
)

if TYPE_CHECKING:
    from seamark.cli.output_folder import OutputFolder
    from seamark.cli.solutions import FindIsolation
    from seamark.programs.preparation import PreparedProgram
    from seamark.worker.ipc.outcomes import RunOutcome


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalRun:
    """A run as the options describe it, checked."""

    benchmark: str
    config: dict[str, Any]
    controller: str
    role: str
    program: PreparedProgram | None
    parts: Mapping[str, PreparedProgram] = field(default_factory=dict)  # role -> program
    seed: int
    trials: int


@click.command()
@benchmark_argument
@run_options
@part_options
@click.option("--out", type=click.Path(path_type=Path), metavar="DIR", help="Folder for the data.")
@click.option(
    "--score",
    metavar="EXPRESSION",
    help="Custom score: an expression over the metrics, as --set score=EXPRESSION.",
)
@json_option
def run(  # noqa: PLR0913  # one argument per option
    *,
    benchmark: str,
    controller: str | None,
    pairs: tuple[str, ...],
    config: Path | None,
    seed: int | None,
    trials: int | None,
    out: Path | None,
    score: str | None,
    as_json: bool,
    **parts: Path | None,
) -> None:
    """Evaluate a controller or tracker on this machine, bit for bit as on a server.

    --out DIR gets manifest.json, metrics.json, telemetry.csv and log.txt.

    \b
    Examples:
      seamark run currents-v3 --controller pi --set kp=0.5 --set ki=0.02 --seed 7 --out result
      seamark run currents-v3 --controller my_controller.py --set levels=0,0.2 --trials 3
      seamark run currents-v3 --config config.json --json
      seamark run visibility-v3 --set tracker=esm --set warp=srt
      seamark run visibility-v3 --controller my_tracker.py
      seamark run mission-v1 --controller chain --detector-program my_detector.py
    """
    from seamark.cli.extras import absent_in_box
    from seamark.cli.output_folder import OutputFolder
    from seamark.cli.solutions import probing

    if score is not None:
        pairs = (*pairs, f"score={score}")
    given = parts_in(parts)
    boxes = bool(given) or (controller is not None and Path(controller).exists())
    with probing(needed=boxes) as isolation:
        local_run = _local_run(
            *(benchmark, controller, pairs, config), trials=trials or 1, seed=seed, parts=given
        )
        output = OutputFolder(out)
        output.comments = _header_comments(local_run)
        if not as_json:
            click.echo(
                f"{benchmark}, {local_run.controller}, seed {local_run.seed}, "
                f"trials {local_run.trials}"
            )
        try:
            outcome = _evaluate(local_run, output, isolation, quiet=as_json)
        except KeyboardInterrupt:
            output.save(local_run.benchmark, None)
            click.echo("Stopped." + (f" Partial data: {out}" if out else ""), err=True)
            exit_with(INTERRUPTED)
    output.save(local_run.benchmark, outcome)
    report(local_run, outcome, out, as_json=as_json)
    if install := absent_in_box(outcome.sentence):
        click.echo(install, err=True)
    exit_with(0 if outcome.failure is None else 1)


def _local_run(
    benchmark: str,
    controller: str | None,
    pairs: tuple[str, ...],
    file: Path | None,
    *,
    trials: int,
    seed: int | None,
    parts: Mapping[str, Path],
) -> LocalRun:
    from seamark.cli.configuration import benchmark_of, run_configuration_of
    from seamark.cli.solutions import choose, prepare_parts, prepare_valid
    from seamark.sim import registry
    from seamark.sim.engine.seeds import SEED_MAX

    benchmark_of(benchmark)  # first: the message about an unknown one has the names of all
    name, path = choose(controller, benchmark)
    program = None if path is None else prepare_valid(path, benchmark=benchmark)
    return LocalRun(
        benchmark=benchmark,
        config=run_configuration_of(benchmark, file, pairs, program),
        controller=name,
        role=registry.benchmark(benchmark).role,
        program=program,
        parts=prepare_parts(parts, benchmark=benchmark),
        seed=secrets.randbelow(SEED_MAX + 1) if seed is None else seed,
        trials=trials,
    )


def _header_comments(local_run: LocalRun) -> list[str]:
    """Return the comments in the header of the telemetry."""
    from seamark.sim import registry
    from seamark.sim.recording import telemetry
    from seamark.sim.settings import grid

    benchmark = registry.benchmark(local_run.benchmark)
    program = local_run.program is not None
    solution = (
        local_run.controller
        if program
        else benchmark.solution_label_of(local_run.controller, local_run.config)
    )
    parts = "".join(f", {role} {one.name}" for role, one in local_run.parts.items())
    return [
        f"{local_run.role} {solution}{parts}, seed {local_run.seed}, trials {local_run.trials}",
        *grid.level_comments(benchmark.restore(local_run.config)),
        telemetry.units(),
    ]


def _evaluate(
    local_run: LocalRun,
    output: OutputFolder,
    isolation: FindIsolation,
    *,
    quiet: bool,
) -> RunOutcome:
    from seamark.cli.simulator_loading import loading_shown
    from seamark.cli.solutions import sandbox_failures_explained
    from seamark.progress import Progress

    with (
        sandbox_failures_explained(),
        Progress(local_run.benchmark, quiet=quiet) as bar,
        loading_shown(bar),
    ):
        level = isolation(local_run.benchmark)
        from seamark.worker.evaluation.local import Callbacks, evaluate_locally

        callbacks = Callbacks(
            rows=output.add_rows,
            log=output.add_log,
            trial_restarted=output.discard,
            progress=lambda p: bar.show(p.fraction, f"{p.t_simulated:.0f} s simulated"),
        )
        return evaluate_locally(
            local_run.benchmark,
            local_run.config,
            seed=local_run.seed,
            trials=local_run.trials,
            controller=local_run.program or local_run.controller,
            parts=local_run.parts,
            callbacks=callbacks,
            isolation=level,
        )


def report(local_run: LocalRun, outcome: RunOutcome, out: Path | None, *, as_json: bool) -> None:
    """Print how a run ended."""
    from seamark.cli.run_summary import custom_score, level_table
    from seamark.sandbox.printable_text import printable_text
    from seamark.sim.recording.manifest import contacts
    from seamark.sim.registry import benchmark

    metrics = outcome.metrics or {}
    if as_json:
        print_json(
            {
                "benchmark": local_run.benchmark,
                "controller": local_run.controller,
                "seed": local_run.seed,
                "trials": local_run.trials,
                "verdict": outcome.failure or "ok",
                "sentence": outcome.sentence,
                "traceback": outcome.traceback,
                "score": metrics.get("score"),
                "own_score": metrics.get("own_score"),
                "metrics": outcome.metrics,
                "contacts": contacts(benchmark(local_run.benchmark).read(local_run.config)),
                "digest": outcome.digest,
                "out": str(out) if out else None,
            }
        )
        return
    if outcome.failure is not None:
        text = f"Failed ({outcome.failure}): {outcome.sentence}\n{outcome.traceback.rstrip()}"
        click.echo(printable_text(text), err=True)
    else:
        for line in level_table(metrics):
            click.echo(line)
        click.echo(f"score   {metrics['score']:.4g}")
        for line in custom_score(metrics):
            click.echo(line)
    click.echo(f"digest  {outcome.digest}")
    if out is not None:
        click.echo(f"data    {out}")
