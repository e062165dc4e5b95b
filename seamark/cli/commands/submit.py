"""`seamark submit`: submit a run to a server."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from seamark.cli.console import exit_with, print_json
from seamark.cli.options import (
    benchmark_argument,
    json_option,
    part_options,
    parts_in,
    run_options,
    server_options,
)
from seamark.cli.run_summary import exit_code, summary
from seamark.failures import UsageRefused
from seamark.programs.licences import LICENCES, NO_PROGRAM
from seamark.sandbox.printable_text import printable_text

if TYPE_CHECKING:
    from seamark.client import Run, Sweep
    from seamark.client.documents import PublicationTerms, SubmissionOptions

GUEST = (
    "Without a token, what you submit belongs to a guest whom only this command knows: no browser "
    "can open its page. Create an account and name its token with --token."
)


@click.command()
@benchmark_argument
@run_options
@part_options
@click.option("--ranked", is_flag=True, help="Run on the benchmark's scenario and seeds, to rank.")
@click.option("--title", default="", help="Title in the list of runs.")
@click.option(
    "--sweep",
    "swept",
    metavar="KEY=VALUES",
    multiple=True,
    help="Start a run for each value of a setting or parameter: a list with commas, or "
    "FROM:TO:COUNT. Twice: for each combination.",
)
@click.option("--wait", is_flag=True, help="Wait until the run, or the sweep, has ended.")
@click.option("--publish", is_flag=True, help="Wait, and make the run public if it succeeds.")
@click.option(
    "--competition",
    metavar="NAME",
    help="Submit it for your team to the round of a competition that is open.",
)
@click.option(
    "--method",
    default="",
    help="With --publish or --competition: name of the method, which the leaderboard shows.  "
    "[default: label of the built-in solution]",
)
@click.option(
    "--licence",
    type=click.Choice(list(LICENCES)),
    help="With --publish: licence of the program, an SPDX identifier.  [default: none is granted]",
)
@click.option(
    "--results-only", is_flag=True, help="With --publish: keep the program and its log private."
)
@click.option("--anonymous", is_flag=True, help="With --publish: for review, without your name.")
@server_options
@json_option
def submit(  # noqa: PLR0913 (one argument per option is click's way)
    *,
    benchmark: str,
    controller: str | None,
    pairs: tuple[str, ...],
    config: Path | None,
    seed: int | None,
    trials: int | None,
    ranked: bool,
    title: str,
    swept: tuple[str, ...],
    wait: bool,
    publish: bool,
    competition: str | None,
    method: str,
    licence: str | None,
    results_only: bool,
    anonymous: bool,
    server: str,
    token: str | None,
    as_json: bool,
    **parts: Path | None,
) -> None:
    """Submit a run of a controller or tracker (a file or a built-in one) to a server.

    \b
    Examples:
      seamark submit currents-v3 --controller my_controller.py --token $TOKEN --wait
      seamark submit currents-v3 --controller pi --set kp=0.6 --seed 7
      seamark submit currents-v3 --controller my_controller.py --ranked --publish \\
        --method "Sliding mode with observer" --licence MIT --token $TOKEN
      seamark submit currents-v3 --controller pi --sweep kp=0.1:1.0:5 --sweep ki=0,0.02,0.05
      seamark submit currents-v3 --controller pi --set vehicle=my_rov.toml --token $TOKEN
      seamark submit currents-v3 --controller my_controller.py --competition harbour-cup-v1 \\
        --method "Sliding mode with observer" --token $TOKEN
    """
    from seamark.cli.configuration import read_settings, taken_vehicle, typed_if_known
    from seamark.cli.server_answers import refusals_shown
    from seamark.cli.solutions import choose, choose_parts
    from seamark.client import Client

    name, program = choose(controller, benchmark)
    own_parts = choose_parts(parts_in(parts), benchmark=benchmark)
    settings, vehicle = taken_vehicle(read_settings(config, pairs))
    submission: SubmissionOptions = {
        "controller": name if program is None else None,
        "program": program,
        "tracker_program": own_parts.get("tracker"),
        "detector_program": own_parts.get("detector"),
        "vehicle": vehicle,
        "config": typed_if_known(benchmark, settings),
        "kind": "ranked" if ranked else "practice",
        "seed": seed,
        "trials": trials,
        "title": title,
    }
    axes = read_settings(None, swept, option="--sweep")
    fixed = {"--ranked": ranked, "--sweep": bool(axes), "--publish": publish}
    fixed |= {"--seed": seed is not None, "--trials": trials is not None}
    submission |= _entry(competition, method, token, fixed)
    terms: PublicationTerms = {
        "method": method,
        "program": not results_only,
        "licence": licence,
        "anonymous": anonymous,
    }
    if publish:
        own = program is not None or bool(own_parts)
        _check_publication(terms, sweep=bool(axes), own_program=own, token=token)
    elif (method and competition is None) or licence or results_only or anonymous:
        raise UsageRefused("--method, --licence, --results-only and --anonymous need --publish.")
    with refusals_shown(), Client(server, token) as client:
        try:
            if axes:
                sweep = client.sweep(benchmark, axes, **submission)
            else:
                run = client.submit(benchmark, **submission)
        except OSError as error:
            file = error.filename or program
            raise UsageRefused(f"{file} cannot be read: {error.strerror}.") from None
        if vehicle is not None and not as_json:
            click.echo(printable_text(f"The vehicle of {vehicle} is uploaded."))
        if not token:
            click.echo(GUEST, err=True)
        if axes:
            _finish_sweep(sweep, wait=wait, as_json=as_json)
        else:
            _finish_run(
                run, wait=wait or publish, terms=terms if publish else None, as_json=as_json
            )


def _finish_sweep(sweep: Sweep, *, wait: bool, as_json: bool) -> None:
    if not as_json:
        runs = len(sweep.document["cells"])
        click.echo(printable_text(f"Sweep {sweep.id} has {runs} runs: {sweep.page}"))
    if wait:
        sweep.wait(progress=not as_json)
    if as_json:
        print_json(sweep.document)
    elif wait:
        best = "No run succeeded." if sweep.best is None else _best(sweep.best)
        click.echo(printable_text(best))


def _best(run: Run) -> str:
    return f"Best: run {run.id} with score {run.score:.4g}, {run.page}"


def _check_publication(
    terms: PublicationTerms, *, sweep: bool, own_program: bool, token: str | None
) -> None:
    """Refuse what the server would refuse too, but only after the run."""
    if sweep:
        raise UsageRefused("--publish is for one run; publish those of a sweep on their pages.")
    if not token:
        raise UsageRefused("Publishing needs an account: name its token with --token.")
    if own_program and not terms["method"].strip():
        raise UsageRefused("Name the method that you publish, with --method.")
    if terms["licence"] is not None and not (own_program and terms["program"]):
        raise UsageRefused(NO_PROGRAM)


def _entry(
    competition: str | None, method: str, token: str | None, fixed: Mapping[str, bool]
) -> SubmissionOptions:
    """Return what makes a run an entry of a competition.

    Raises
    ------
    UsageRefused
        An option says what the competition fixes, or there is no account.
    """
    if competition is None:
        return {}
    if wrong := next((name for name, is_given in fixed.items() if is_given), ""):
        raise UsageRefused(f"A competition fixes what {wrong} says: leave it out.")
    if not token:
        raise UsageRefused("A competition needs an account: name its token with --token.")
    return {"competition": competition, "method": method}


def _finish_run(run: Run, *, wait: bool, terms: PublicationTerms | None, as_json: bool) -> None:
    if not as_json:
        click.echo(printable_text(f"Run {run.id} is {run.state}: {run.page}"))
    if wait:
        run.wait(progress=not as_json)
    try:
        if terms is not None and run.state == "succeeded":
            run.publish(**terms)
    finally:  # the result is there, also if the server refuses to publish it
        _show(run, ended=wait, as_json=as_json)
    exit_with(exit_code(run.document) if wait else 0)


def _show(run: Run, *, ended: bool, as_json: bool) -> None:
    if as_json:
        print_json(run.document)
    elif ended:
        click.echo(summary(run.document))
        if run.public:
            click.echo(printable_text(f"Published: {run.page}"))
