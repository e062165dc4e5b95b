"""`seamark submit`: submit a run to a server."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from seamark.cli.console import exit_with, print_json
from seamark.cli.options import json_option, run_options, server_options
from seamark.cli.run_summary import summary
from seamark.failures import PlatformFailed, UsageRefused
from seamark.sandbox.printable_text import printable_text


@click.command()
@click.argument("benchmark")
@run_options
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
@click.option("--wait", is_flag=True, help="Wait until the run has ended.")
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
    server: str,
    token: str | None,
    as_json: bool,
) -> None:
    """Submit a run of a controller or tracker (a file or a built-in one) to a server.

    \b
    Examples:
      seamark submit currents-v1 --controller my_controller.py --token $TOKEN --wait
      seamark submit currents-v1 --controller pi --set kp=0.6 --seed 7
      seamark submit currents-v1 --controller my_controller.py --ranked --token $TOKEN
      seamark submit currents-v1 --controller pi --sweep kp=0.1:1.0:5 --sweep ki=0,0.02,0.05
    """
    from seamark.cli.configuration import read_settings
    from seamark.cli.solutions import choose
    from seamark.client import Client, ServerRefused, ServerUnavailable

    name, program = choose(controller, benchmark)
    submission: dict[str, Any] = {
        "config": _typed(benchmark, read_settings(config, pairs)),
        "kind": "ranked" if ranked else "practice",
        "seed": seed,
        **({} if trials is None else {"trials": trials}),
        "title": title,
    }
    axes = read_settings(None, swept, option="--sweep")
    if axes and wait:
        raise UsageRefused("--wait follows one run; a sweep has a page that shows its runs.")
    try:
        with Client(server, token) as client:
            if axes:
                sweep = client.sweep(
                    benchmark, axes, controller=name, program=program, **submission
                )
                _announce_sweep(sweep, server, as_json=as_json)
                return
            run = client.submit(benchmark, controller=name, program=program, **submission)
            _announce(run, server, as_json=as_json)
            if wait:
                run = _follow(client, run, quiet=as_json)
    except ServerUnavailable as error:
        raise PlatformFailed(str(error)) from None
    except ServerRefused as refusal:
        raise _failure(refusal.status)(printable_text(str(refusal))) from None
    except OSError as error:
        raise UsageRefused(f"{name} cannot be read: {error.strerror}.") from None
    _finish(run, waited=wait, as_json=as_json)


def _typed(benchmark: str, values: dict[str, Any]) -> dict[str, Any]:
    """Convert strings if this installation knows the benchmark; otherwise the server does."""
    from seamark.cli.configuration import typed
    from seamark.sim import registry

    if benchmark not in registry.BENCHMARKS:
        return values
    return typed(values, registry.benchmark(benchmark).schema())


def _failure(status: int) -> type[UsageRefused] | type[PlatformFailed]:
    return PlatformFailed if status >= 500 else UsageRefused


def _announce(run: dict[str, Any], server: str, *, as_json: bool) -> None:
    if not as_json:
        page = server.rstrip("/") + run["links"]["page"]
        click.echo(printable_text(f"Run {run['id']} is {run['state']}: {page}"))


def _announce_sweep(sweep: dict[str, Any], server: str, *, as_json: bool) -> None:
    if as_json:
        print_json(sweep)
        return
    page = server.rstrip("/") + sweep["links"]["page"]
    click.echo(printable_text(f"Sweep {sweep['id']} has {len(sweep['cells'])} runs: {page}"))


def _follow(client: Any, run: dict[str, Any], *, quiet: bool) -> dict[str, Any]:
    from seamark.cli.console import Progress

    with Progress(f"run {run['id']}", quiet=quiet) as progress:

        def show(now: dict[str, Any]) -> None:
            position = now["position"]
            note = f"queued, position {position}" if position else printable_text(now["state"])
            progress.show(now["progress"], note, state=note)

        ended: dict[str, Any] = client.wait(run["id"], show)
    return ended


def _finish(run: dict[str, Any], *, waited: bool, as_json: bool) -> None:
    if as_json:
        print_json(run)
    elif waited:
        click.echo(summary(run))
    if not waited or run["state"] == "succeeded":
        exit_with(0)
    cause = (run["failure"] or {}).get("cause")
    exit_with(3 if cause == "platform_error" else 1)
