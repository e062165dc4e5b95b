"""`seamark up`: the whole service on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from seamark.cli.console import exit_with, print_json
from seamark.cli.options import data_option, json_option, settings_of

if TYPE_CHECKING:
    from seamark.server.settings import Settings


@click.command()
@click.option("--port", type=click.IntRange(0, 65535), help="Port; 0: any.  [default: 8000]")
@click.option("--host", metavar="ADDRESS", help="Address to listen on.  [default: 127.0.0.1]")
@click.option(
    "--workers", type=click.IntRange(1, 512), help="Runs at the same time. [default: cores]"
)
@click.option(
    "--ready-file",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write the address to FILE as soon as the pages are up.",
)
@data_option
@json_option
def up(
    *,
    port: int | None,
    host: str | None,
    workers: int | None,
    ready_file: Path | None,
    data: Path | None,
    as_json: bool,
) -> None:
    """Start the whole service on this machine: database, broker, web server, worker.

    All data is kept in the data folder. Ctrl-C stops the service; runs that were under way start
    again at the next `seamark up`.

    \b
    Examples:
      seamark up
      seamark up --port 8080 --data ~/seamark
      SEAMARK_PUBLIC=true seamark up --host 0.0.0.0
    """
    from seamark.cli.extras import refuse_packages_of_the_user
    from seamark.embedded.service import Embedded, address_of, free_port

    refuse_packages_of_the_user()
    settings = settings_of(data, port=port, host=host, workers=workers)
    if settings.port == 0:
        settings = settings.model_copy(update={"port": free_port(settings.host)})
    notes = _silent if as_json else click.echo
    notes(f"Starting Seamark in {settings.data} ...")
    isolation = _isolation(settings)

    def pages_up(ready: Settings) -> None:
        if ready_file is not None:
            ready_file.write_text(f"{address_of(ready)}\n")
        notes(f"The pages are up: {address_of(ready)}  The worker is starting ...")

    service = Embedded(settings, notes)
    stop_signal = service.run(
        lambda ready: _show(ready, isolation, as_json=as_json), pages_up=pages_up
    )
    notes(f"Stopped ({stop_signal.name}). All data is kept in {settings.data}.")
    exit_with(0)


def _silent(_: str) -> None:
    """Print nothing: a program reads the one JSON object."""


def _isolation(settings: Settings) -> tuple[str, str]:
    """Return the level that this host reaches and what it means for uploads."""
    from seamark.sandbox.isolation.level import IsolationLevel
    from seamark.sandbox.probing.probes import probe

    found = probe()
    needed = IsolationLevel[settings.sandbox_min_level.upper()]
    name = found.level.name.lower()
    if found.level >= needed and found.level > IsolationLevel.NONE:
        return name, f"isolated, level {name}"
    return name, (
        f"refused: this machine isolates only {name}, {settings.sandbox_min_level} is needed. "
        "`seamark doctor` says how to fix it; built-in controllers still work."
    )


def _show(settings: Settings, isolation: tuple[str, str], *, as_json: bool) -> None:
    from seamark.embedded.service import address_of

    address = address_of(settings)
    if as_json:
        print_json({"address": address, "data": str(settings.data), "isolation": isolation[0]})
        return
    click.echo("")
    click.echo(f"  Seamark is ready:  {click.style(address, bold=True)}")
    click.echo("")
    click.echo(f"  data       {settings.data}")
    click.echo(f"  runs       {settings.workers} at the same time")
    click.echo(f"  uploads    {isolation[1]}")
    click.echo(f"  logs       {settings.data / 'logs'}")
    click.echo("  stop       Ctrl-C")
    click.echo("")
