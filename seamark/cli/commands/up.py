"""`seamark up`: the whole service on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from seamark.cli.console import exit_with, print_json
from seamark.cli.local_service import data_option, settings_of
from seamark.cli.options import json_option

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
@click.option("--installer", type=click.Path(path_type=Path), hidden=True)  # of `./run`
@data_option
@json_option
def up(
    *,
    port: int | None,
    host: str | None,
    workers: int | None,
    ready_file: Path | None,
    installer: Path | None,
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
    from seamark.drafts import replace_file
    from seamark.embedded.service import Embedded, address_of, free_port
    from seamark.server.storage.private_files import tighten

    refuse_packages_of_the_user()
    settings = settings_of(data, port=port, host=host, workers=workers)
    tighten(settings)
    if settings.port == 0:
        settings = settings.model_copy(update={"port": free_port(settings.host)})
    notes = _silent if as_json else click.echo
    notes(f"Starting Seamark in {settings.data} ...")

    def pages_up(ready: Settings) -> None:
        if ready_file is not None:
            replace_file(ready_file, f"{address_of(ready)}\n".encode())
        notes(f"The pages are up: {address_of(ready)}  The worker is starting ...")

    service = Embedded(settings, notes, installer=installer)
    stop_signal = service.run(lambda ready: _show(ready, as_json=as_json), pages_up=pages_up)
    notes(f"Stopped ({stop_signal.name}). All data is kept in {settings.data}.")
    exit_with(0)


def _silent(_: str) -> None:
    """Print nothing: a program reads the one JSON object."""


def _uploads(settings: Settings) -> tuple[str, str]:
    """Return the isolation level of the worker and what it means for uploads."""
    from seamark.sandbox.languages import DEFAULT_LANGUAGE
    from seamark.server.database.engine import Database
    from seamark.server.messaging import workers
    from seamark.server.storage import installation

    database = Database(settings.database_url)
    try:
        with database.reading() as session:
            levels = [worker.level for worker in workers.listed(session) if worker.claims]
            refusal = workers.upload_refusal(session, DEFAULT_LANGUAGE, settings)
    finally:
        database.close()
    level = levels[0] if levels else "none"
    if refusal:
        return level, (
            f"refused: this machine isolates only {level}, {settings.sandbox_min_level} is needed. "
            "`seamark doctor` says how to fix it; built-in controllers still work."
        )
    more = "; more languages are being installed" if installation.is_under_way(settings) else ""
    return level, f"isolated, level {level}{more}"


def _show(settings: Settings, *, as_json: bool) -> None:
    from seamark.embedded.service import address_of

    address, (level, uploads) = address_of(settings), _uploads(settings)
    if as_json:
        print_json({"address": address, "data": str(settings.data), "isolation": level})
        return
    click.echo("")
    click.echo(f"  Seamark is ready:  {click.style(address, bold=True)}")
    click.echo("")
    click.echo(f"  data       {settings.data}")
    click.echo(f"  runs       {settings.workers} at the same time")
    click.echo(f"  uploads    {uploads}")
    click.echo(f"  logs       {settings.data / 'logs'}")
    click.echo("  stop       Ctrl-C")
    click.echo("")
