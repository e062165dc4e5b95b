"""`seamark bridge rosbridge --server`: a program on this machine, and its run on a server."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NoReturn

import click

from seamark.cli.console import INTERRUPTED, exit_with, print_json
from seamark.cli.run_summary import exit_code, summary
from seamark.cli.server_answers import refusals_shown
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from websockets.asyncio.client import ClientConnection

    from seamark.bridge.rosbridge.server import TcpAddress
    from seamark.client import Run


def run_on_server(
    server: str,
    token: str | None,
    wanted: Mapping[str, Any],
    address: TcpAddress,
    say: Callable[[str], None],
) -> Run:
    """Connect the next program that comes to `address` to a run, and return that when it has ended.

    Parameters
    ----------
    wanted
        `benchmark`, `config`, `seed` and `trials` of the run; what is None is left out.
    """
    from seamark.bridge.rosbridge import forwarding
    from seamark.client import Client, retry_after
    from seamark.client.errors import ServerUnavailable, refusal

    with refusals_shown(), Client(server, token) as client:
        if not token:
            raise UsageRefused("A run on a server needs a token: --token, or SEAMARK_TOKEN.")
        url, run_ids = forwarding.address_of(client.server, wanted), list[int]()

        async def open_session() -> ClientConnection:
            session = await forwarding.opened(url, token, say, retry_after.pause_s)
            run_ids.append(forwarding.run_of(session))
            say(f"Run {run_ids[0]}: {client.server}/runs/{run_ids[0]}")
            return session

        def listening(port: int) -> None:
            click.echo(f"Waiting for a program at {address.url(port)}.", err=True)

        try:
            asyncio.run(forwarding.forward_one(address, open_session, listening=listening))
            return client.run(run_ids[0]).wait(progress=False)
        except KeyboardInterrupt:
            click.echo("Stopped.", err=True)
            exit_with(INTERRUPTED)
        except OSError as error:
            where = f"{address.host}:{address.port}"
            raise UsageRefused(f"{where} cannot be used: {error.strerror}.") from None
        except forwarding.Refusal as refused:
            if not refused.status:
                raise ServerUnavailable(str(refused)) from None
            raise refusal(refused.problem, refused.status, None) from None


def finish(run: Run, *, as_json: bool) -> NoReturn:
    """Print a run that has ended, and end the command as it did."""
    if as_json:
        print_json(run.document)
    else:
        click.echo(summary(run.document))
    exit_with(exit_code(run.document))
