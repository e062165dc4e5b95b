"""`seamark submit`: send a controller to a server."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from seamark.cli.options import answer, end, json_option, order_options, say, server_options
from seamark.cli.outcome import explain
from seamark.failures import PlatformFailed, UsageRefused


@click.command()
@click.argument("benchmark")
@order_options
@click.option("--ranked", is_flag=True, help="On the hidden seeds, for the leaderboard.")
@click.option("--title", default="", help="Shown in lists.")
@click.option("--wait", is_flag=True, help="Follow the run until it has ended.")
@server_options
@json_option
def submit(  # noqa: PLR0913 (one argument per option is click's way)
    *,
    benchmark: str,
    controller: str | None,
    pairs: tuple[str, ...],
    config: Path | None,
    seed: int | None,
    trials: int,
    ranked: bool,
    title: str,
    wait: bool,
    server: str,
    token: str | None,
    as_json: bool,
) -> None:
    """Send a controller or tracker (a file, or the name of a built-in one) to a server.

    \b
    Examples:
      seamark submit currents-v1 --controller my_controller.py --token $TOKEN --wait
      seamark submit currents-v1 --controller pi --set kp=0.6 --seed 7
      seamark submit currents-v1 --controller my_controller.py --ranked --token $TOKEN
    """
    from seamark.cli.controllers import choose, read_settings
    from seamark.client import Client, ServerAway, ServerRefused

    name, program = choose(controller, benchmark)
    order: dict[str, Any] = {
        "config": _typed(benchmark, read_settings(config, pairs)),
        "kind": "ranked" if ranked else "practice",
        "seed": seed,
        "trials": trials,
        "title": title,
    }
    try:
        with Client(server, token) as client:
            run = client.submit(benchmark, controller=name, program=program, **order)
            _announce(run, server, as_json=as_json)
            if wait:
                run = _follow(client, run, quiet=as_json)
    except ServerAway as error:
        raise PlatformFailed(str(error)) from None
    except ServerRefused as refusal:
        raise _failure(refusal.status)(str(refusal)) from None
    except OSError as error:
        raise UsageRefused(f"{name} cannot be read: {error.strerror}.") from None
    _finish(run, waited=wait, as_json=as_json)


def _typed(benchmark: str, values: dict[str, Any]) -> dict[str, Any]:
    """Convert texts if this installation knows the benchmark; else the server has to."""
    from seamark.cli.controllers import typed
    from seamark.sim import registry

    if benchmark not in registry.BENCHMARKS:
        return values
    return typed(values, registry.benchmark(benchmark).schema())


def _failure(status: int) -> type[UsageRefused] | type[PlatformFailed]:
    return PlatformFailed if status >= 500 else UsageRefused


def _announce(run: dict[str, Any], server: str, *, as_json: bool) -> None:
    if not as_json:
        page = server.rstrip("/") + run["links"]["page"]
        say(f"Run {run['id']} is {run['state']}: {page}")


def _follow(client: Any, run: dict[str, Any], *, quiet: bool) -> dict[str, Any]:
    from seamark.cli.progress import Progress

    with Progress(f"run {run['id']}", quiet=quiet) as progress:

        def show(now: dict[str, Any]) -> None:
            position = now["position"]
            note = f"waits, place {position}" if position else str(now["state"])
            progress.show(now["progress"], note, state=note)

        ended: dict[str, Any] = client.wait(run["id"], show)
    return ended


def _finish(run: dict[str, Any], *, waited: bool, as_json: bool) -> None:
    if as_json:
        answer(run)
    elif waited:
        say(explain(run))
    if not waited or run["state"] == "succeeded":
        end(0)
    cause = (run["failure"] or {}).get("cause")
    end(3 if cause == "platform_error" else 1)
