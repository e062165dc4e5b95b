"""`seamark compare`: results and runs side by side."""

from __future__ import annotations

import click

from seamark.cli.console import print_json
from seamark.cli.options import json_option, server_options


@click.command()
@click.argument("results", nargs=-1, required=True, metavar="RESULT...")
@server_options
@json_option
def compare(results: tuple[str, ...], *, server: str, token: str | None, as_json: bool) -> None:
    """Compare two to five results: settings that differ, scores, metrics with the best marked.

    A RESULT is the number of a run on a server, or a folder that `seamark run --out` wrote.
    Differences of scores are to the first one. They are paired where trials have the same
    conditions.

    \b
    Examples:
      seamark compare 12 17
      seamark compare 12 17 23 --json --token $TOKEN
      seamark compare pi-result tuned-result
    """
    from seamark.cli.comparison_tables import tables
    from seamark.cli.extras import has_simulator, without_simulator
    from seamark.cli.results import is_run
    from seamark.sandbox.printable_text import printable_text

    link = ""
    if all(is_run(name) for name in results):
        from seamark.cli.server_answers import refusals_shown
        from seamark.client import Client

        with refusals_shown(), Client(server, token) as client:
            compared = client.compare([int(name) for name in results])
        comparison = {**compared}
        ids = ",".join(str(run["id"]) for run in compared["runs"])
        link = f"\n{server.rstrip('/')}/compare?runs={ids}"
    elif not has_simulator():
        raise without_simulator("The comparison of results in folders")
    else:
        from seamark.cli.local_comparison import compare_results
        from seamark.cli.results import results_of

        comparison = compare_results(
            results_of(results, server=server, token=token, telemetry=False)
        )
    if as_json:
        print_json(comparison)
        return
    click.echo(printable_text(tables(comparison)))
    if link:
        click.echo(link)
