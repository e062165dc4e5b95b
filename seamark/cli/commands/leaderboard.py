"""`seamark leaderboard`: a leaderboard of a server."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

import click

from seamark.cli.console import print_json
from seamark.cli.options import benchmark_argument, json_option, server_options

if TYPE_CHECKING:
    from seamark.client.documents import LeaderboardQuery

SHIPPED = "Reference entries that Seamark ships"


@click.command()
@benchmark_argument
@click.option(
    "--per",
    type=click.Choice(["person", "method"]),
    help="One row for each person, or for each named method of a person.  [default: person]",
)
@click.option("--program", type=click.Choice(["uploaded", "built-in"]), help="Kind of program.")
@click.option("--language", help="Language of uploaded programs.")
@click.option("--vehicle", help="Vehicle of the runs.")
@click.option("--tracker", help="Built-in tracker of the runs.")
@click.option(
    "--baselines",
    type=click.Choice(["hide", "only"]),
    help="Hide the reference entries, or show nothing else.",
)
@click.option("--mine", is_flag=True, help="Only the rows of the account; needs a token.")
@click.option("--sort", metavar="METRIC", help="Sort the first rows by another metric.")
@click.option("--limit", type=click.IntRange(1, 500), default=20, show_default=True)
@server_options
@json_option
def leaderboard(
    benchmark: str, *, server: str, token: str | None, as_json: bool, **query: object
) -> None:
    """Show the leaderboard of a BENCHMARK, with the filters of its page.

    The range of a rank is in brackets; reference entries have no rank.

    \b
    Examples:
      seamark leaderboard currents-v3
      seamark leaderboard currents-v3 --program uploaded --language python
      seamark leaderboard currents-v3 --sort power_share --json
    """
    from seamark.cli.comparison_tables import table
    from seamark.cli.server_answers import refusals_shown
    from seamark.client import Client
    from seamark.sandbox.printable_text import printable_text

    chosen = {name: value for name, value in query.items() if value not in (None, False)}
    with refusals_shown(), Client(server, token) as client:
        board = client.leaderboard(benchmark, **cast("LeaderboardQuery", chosen))
    if as_json:
        print_json(board)
        return
    sort = query["sort"]
    heads = ["Rank", "User", "Entry", "Language", "Tracker", "Score", "95 % interval", "Run"]
    heads += [str(sort)] if sort else []
    rows = [_cells(row, sort) for row in board["ranks"]]
    click.echo(printable_text(table(f"Leaderboard of {benchmark}", heads, rows)))
    shipped = [entry for entry in board["reference_entries"] if entry["run"] is None]
    if shipped and query["baselines"] != "hide":
        marks = [[entry["title"], f"{entry['score']:.4g}", _interval(entry)] for entry in shipped]
        shown = table(SHIPPED, ["Entry", "Score", "95 % interval"], marks)
        click.echo(f"\n{printable_text(shown)}")


def _cells(row: Mapping[str, Any], sort: object) -> list[str]:
    rank = "-" if row["rank"] is None else str(row["rank"])
    if row["rank_low"] != row["rank_high"]:
        rank += f" ({row['rank_low']}-{row['rank_high']})"
    cells = [rank, row["user"], row["method"], row["language"] or "built-in"]
    cells += [row["tracker"] or "-", f"{row['score']:.4g}"]
    cells += [_interval(row), str(row["run"])]
    return [*cells, f"{row['metrics'][sort]:.4g}"] if sort else cells


def _interval(row: Mapping[str, Any]) -> str:
    return f"{row['score_low']:.4g} to {row['score_high']:.4g}"
