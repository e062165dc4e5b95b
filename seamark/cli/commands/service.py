"""`seamark web` and `seamark worker`: the processes of a service, one each, for production."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from seamark.cli.console import exit_with, print_json
from seamark.cli.local_service import data_option, settings_of
from seamark.cli.options import json_option
from seamark.failures import PlatformFailed, UsageRefused

if TYPE_CHECKING:
    from seamark.server.settings import Settings

GRACE_S = 10  # for requests under way; streams end at once


@click.command()
@click.option("--host", metavar="ADDRESS", help="Address to listen on.  [default: 127.0.0.1]")
@click.option("--port", type=click.IntRange(0, 65535), help="Port.  [default: 8000]")
@click.option("--processes", type=click.IntRange(1, 64), default=1, show_default=True)
@data_option
@json_option
def web(
    *, host: str | None, port: int | None, processes: int, data: Path | None, as_json: bool
) -> None:
    """Run the web server only (gunicorn). The broker's URL comes from SEAMARK_BROKER_URL.

    With --json, prints the address as JSON before it starts; logs go to standard error.

    \b
    Example:
      SEAMARK_BROKER_URL=redis://broker:6379/0 seamark web --host 0.0.0.0 --processes 2
    """
    settings = _settings(data, host=host, port=port)
    from seamark.embedded.web_server import serve

    if as_json:
        address = f"http://{settings.host}:{settings.port}"
        print_json({"address": address, "data": str(settings.data), "processes": processes})
    serve(settings, processes=processes, grace_s=GRACE_S)


@click.command()
@click.option("--cores", type=click.IntRange(1, 512), help="Runs at the same time.  [default: all]")
@click.option("--ping", is_flag=True, help="Ask whether the workers of this host hang, and end.")
@data_option
@json_option
def worker(cores: int | None, ping: bool, data: Path | None, as_json: bool) -> None:
    """Run a worker only (Celery). The broker's URL comes from SEAMARK_BROKER_URL.

    With --json, prints what it runs as JSON before it starts. With --ping, the exit code is 0 if a
    worker of this host answers, or cannot be asked because the broker is away, and 3 if it hangs.
    """
    from seamark.server.settings import SIGNS_NOTHING

    settings = _settings(data, workers=cores, secret_key=SIGNS_NOTHING)
    if ping:
        _ping(settings, as_json)
        return
    from seamark.server.database import schema
    from seamark.server.database.data_folder import WrongDataFolder
    from seamark.worker.service.command_line import ONE_THREAD, worker_arguments

    try:
        schema.check_all(settings, computes=True)
    except (schema.SchemaTooOld, WrongDataFolder) as error:
        raise PlatformFailed(f"{error}.") from None
    environ = {k: v for k, v in os.environ.items() if not k.startswith("SEAMARK_")}
    environ |= ONE_THREAD | settings.environment()
    if as_json:
        print_json({"data": str(settings.data), "runs_at_once": settings.workers})
    arguments = [
        sys.executable,
        *worker_arguments(settings, quiet=as_json or not sys.stdout.isatty()),
    ]
    os.execve(sys.executable, arguments, environ)  # noqa: S606 (no shell)


def _ping(settings: Settings, as_json: bool) -> None:
    from seamark.worker.service import ping

    why = ping.problem(settings)
    if as_json:
        print_json({"answers": why is None, "why": why})
        exit_with(3 if why else 0)
    if why:
        raise PlatformFailed(f"{why[0].upper()}{why[1:]}.")
    click.echo("The worker answers.")


def _settings(data: Path | None, **chosen: Any) -> Settings:
    from seamark.cli.extras import refuse_packages_of_the_user

    refuse_packages_of_the_user()
    settings = settings_of(data, **chosen)
    if not settings.broker_url:
        raise UsageRefused(
            "SEAMARK_BROKER_URL is not set. `seamark up` brings a broker of its own; single "
            "processes need one that runs, for example redis://localhost:6379/0."
        )
    from seamark.server.storage.private_files import tighten

    tighten(settings)
    return settings
