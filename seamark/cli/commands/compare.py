"""`seamark compare`: runs of a server side by side."""

from __future__ import annotations

import click

from seamark.cli.console import print_json
from seamark.cli.options import json_option, server_options


@click.command()
@click.argument("runs", type=click.IntRange(min=1), nargs=-1, required=True, metavar="RUN...")
@server_options
@json_option
def compare(runs: tuple[int, ...], *, server: str, token: str | None, as_json: bool) -> None:
    """Compare two to five runs: settings that differ, scores, metrics with the best marked.

    Differences of scores are to the first run. They are paired where trials are in the same water.

    \b
    Examples:
      seamark compare 12 17
      seamark compare 12 17 23 --json --token $TOKEN
    """
    from seamark.cli.comparison_tables import tables
    from seamark.cli.server_answers import refusals_shown
    from seamark.client import Client
    from seamark.sandbox.printable_text import printable_text

    with refusals_shown(), Client(server, token) as client:
        found = client.compare(runs)
    if as_json:
        print_json(found)
        return
    click.echo(printable_text(tables(found)))
    ids = ",".join(str(run["id"]) for run in found["runs"])
    click.echo(f"\n{server.rstrip('/')}/compare?runs={ids}")
