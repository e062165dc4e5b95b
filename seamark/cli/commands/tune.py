"""`seamark tune`: search for the best gains of a controller, and check them on fresh trials."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from seamark.cli.console import INTERRUPTED, exit_with, print_json
from seamark.cli.options import (
    benchmark_argument,
    configuration_options,
    controller_option,
    json_option,
    token_option,
)

if TYPE_CHECKING:
    from seamark.cli.tuning_report import Report
    from seamark.cli.tuning_task import TuningTask
    from seamark.tuning.search import Search
    from seamark.tuning.validation import Validation


@click.command()
@benchmark_argument
@controller_option
@click.option(
    "--param",
    "params",
    metavar="NAME[=RANGE]",
    multiple=True,
    help="What to tune: NAME=LOW:HIGH, NAME=LOW:HIGH:log, NAME=VALUE,VALUE or NAME for its "
    "declared range; repeatable.  [default: all parameters with a range that the program declares]",
)
@click.option(
    "--method",
    type=click.Choice(("bayesian", "cma-es", "random", "grid")),
    default="bayesian",
    show_default=True,
    help="How candidates are chosen.",
)
@click.option(
    "--candidates",
    type=click.IntRange(1, 10_000),
    default=40,
    show_default=True,
    help="How many to try beside the defaults; for a grid at most.",
)
@click.option(
    "--batch",
    type=click.IntRange(1, 256),
    default=8,
    show_default=True,
    help="How many are chosen at a time. The result depends on it, and not on --jobs.",
)
@click.option(
    "--trials",
    type=click.IntRange(1, 100),
    default=4,
    show_default=True,
    help="Trials of each candidate, the same for all.",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 2),
    default=1,
    show_default=True,
    help="Seed of the trials and of the search.",
)
@click.option(
    "--validate",
    type=click.IntRange(0, 100),
    default=24,
    show_default=True,
    help="Fresh trials of the best and of the defaults; 0: none.",
)
@configuration_options
@click.option(
    "--jobs",
    type=click.IntRange(1),
    help="Candidates at a time.  [default: one per core; on a server as many as your quota allows]",
)
@click.option(
    "--server",
    metavar="URL",
    help="Run the candidates as practice runs on this server.  [default: on this machine]",
)
@token_option
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    default=Path("tuned.toml"),
    show_default=True,
    help="File for the best configuration; the history gets the same name with .csv.",
)
@click.option("--resume", is_flag=True, help="Go on with the history of an earlier call.")
@json_option
def tune(benchmark: str, **options: Any) -> None:
    """Search for the best settings of a controller or parameters of a program.

    All candidates run the same trials. At the end the best and the defaults run fresh trials, which
    shows whether the best is better or was lucky. Ctrl-C keeps what is there, and cancels runs on a
    server that have not ended; --resume goes on.

    \b
    Examples:
      seamark tune currents-v3 --controller pi --param kp=0.1:2 --param ki=0:0.5:log
      seamark tune currents-v3 --controller mine.py --method cma-es --candidates 80
      seamark tune currents-v3 --controller pi --param kp --param ki --resume
      seamark tune currents-v3 --controller mine.py --server https://seamark.example.org
      seamark run currents-v3 --controller pi --config tuned.toml
    """
    from seamark.cli.tuning_report import Report
    from seamark.cli.tuning_task import Options, task_of
    from seamark.failures import PlatformFailed, UsageRefused

    task = task_of(benchmark, Options(**options))
    report = Report(task, quiet=options["as_json"])
    try:
        search, validation = _tune(task, report)
    except KeyboardInterrupt:
        report.interrupted()
        exit_with(INTERRUPTED)
    except (PlatformFailed, UsageRefused):
        if report.ended:
            report.interrupted()
        raise
    if options["as_json"]:
        print_json(report.document(search, validation))
    else:
        report.finish(search, validation)
    exit_with(0 if search.best() else 1)


def _tune(task: TuningTask, report: Report) -> tuple[Search, Validation | None]:
    """Search, write the best configuration, and validate it."""
    from seamark.cli.server_answers import refusals_shown
    from seamark.cli.solutions import sandbox_failures_explained
    from seamark.tuning.candidates import DEFAULTS
    from seamark.tuning.search import Search
    from seamark.tuning.validation import fresh_seed, validate

    method = task.method()
    runs = task.evaluator(progress=report.show_validation, notice=report.notice)
    history = task.history()
    with sandbox_failures_explained(), refusals_shown(), runs as evaluator:
        search = Search(
            method=method,
            evaluator=evaluator,
            configure=task.configuration,
            history=history,
            on_end=report.candidate_ended,
        )
        with report.searching():
            search.run(task.defaults, limit=task.options.candidates, batch=task.options.batch)
        best = search.best()
        if best is None:
            return search, None
        task.write(best[0].values)
        if not task.options.validate or best[0].number == DEFAULTS:
            return search, None
        seed = fresh_seed(task.options.seed)
        with report.validating():
            return search, validate(
                evaluator,
                task.configuration(best[0].values),
                task.configuration(task.defaults),
                seed=seed,
                trials=task.options.validate,
                block=task.block,
            )
