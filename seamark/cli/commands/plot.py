"""`seamark plot`: results in the terminal or as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from seamark.cli.console import print_json
from seamark.cli.options import json_option, server_options
from seamark.cli.output_folder import draft_of
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from seamark.plots.charts import Chart

KINDS = ("error", "current", "path", "levels")
RESULTS_MAX = 5
COLUMNS_MIN, COLUMNS_MAX = 40, 120
FORMATS = (".png", ".pdf", ".svg")


@click.command()
@click.argument("results", nargs=-1, required=True, metavar="RESULT...")
@click.option(
    "--only",
    "kinds",
    type=click.Choice(KINDS),
    multiple=True,
    help="Draw only this; repeatable.  [default: all]",
)
@click.option("--trial", type=click.IntRange(1), default=1, show_default=True, help="Which trial.")
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write a picture instead: .png, .pdf or .svg.",
)
@server_options
@json_option
def plot(
    results: tuple[str, ...],
    *,
    kinds: tuple[str, ...],
    trial: int,
    out: Path | None,
    server: str | None,
    token: str | None,
    as_json: bool,
) -> None:
    """Plot up to five results over each other: error, current, path and levels.

    A RESULT is a folder that `seamark run --out` wrote, or the number of a run on a server.

    \b
    Examples:
      seamark plot result
      seamark plot pi-result tuned-result --only error --only levels
      seamark plot result --out result.png
      seamark plot 12 17 --token $TOKEN
    """
    from seamark.cli.results import results_of
    from seamark.plots.charts import PICTURE_POINTS, charts

    if len(results) > RESULTS_MAX:
        raise UsageRefused(f"Up to {RESULTS_MAX} results can be plotted over each other.")
    if out is not None and out.suffix.lower() not in FORMATS:
        raise UsageRefused(f"--out {out}: name it {', '.join(FORMATS[:-1])} or {FORMATS[-1]}.")
    plotted = results_of(results, server=server, token=token, telemetry=True)
    columns, coloured = _terminal()
    points = PICTURE_POINTS if out or as_json else 2 * columns
    drawn = charts(plotted, kinds=kinds or KINDS, trial=trial - 1, points=points)
    names = ", ".join(result.name for result in plotted)
    title = f"{plotted[0].benchmark}: {names}, trial {trial}"
    if out is not None:
        _save(drawn, out, title)
    if as_json:
        print_json({"charts": [chart.to_json() for chart in drawn], "out": out and str(out)})
    elif out is not None:
        click.echo(f"Wrote {out}.")
    else:
        _print(drawn, title, columns, coloured=coloured)


def _terminal() -> tuple[int, bool]:
    """Return the width of the terminal, and whether it shows colours."""
    from rich.console import Console

    console = Console()
    columns = min(max(console.width, COLUMNS_MIN), COLUMNS_MAX)
    return columns, console.color_system is not None and not console.no_color


def _print(drawn: Sequence[Chart], title: str, columns: int, *, coloured: bool) -> None:
    from seamark.plots.terminal import text
    from seamark.sandbox.printable_text import printable_text

    click.echo(printable_text(title))
    for chart in drawn:
        click.echo("\n" + text(chart, columns=columns, coloured=coloured))


def _save(drawn: Sequence[Chart], out: Path, title: str) -> None:
    from seamark.cli.extras import install_line, missing

    if missing(("matplotlib",)):
        raise UsageRefused(f"Pictures need Matplotlib: {install_line('plot')}.")
    from seamark.plots.picture import save

    with draft_of(out) as file:
        save(drawn, file, kind=out.suffix[1:].lower(), title=title)
