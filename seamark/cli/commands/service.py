"""`seamark web`, `worker`, `beat`: the processes of a service, one each, for production."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from seamark.cli.options import data_option, settings_of
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from seamark.server.settings import Settings

THREADS = 256  # live streams keep a thread each; Settings.streams_max is below it
GRACE_S = 3  # longer only makes open streams delay the end


@click.command()
@click.option("--host", metavar="ADDRESS", help="Address to listen on.  [default: 127.0.0.1]")
@click.option("--port", type=click.IntRange(0, 65535), help="Port.  [default: 8000]")
@click.option("--processes", type=click.IntRange(1, 64), default=1, show_default=True)
@data_option
def web(host: str | None, port: int | None, processes: int, data: Path | None) -> None:
    """Run the web server only (gunicorn). The broker's URL comes from SEAMARK_BROKER_URL.

    \b
    Example:
      SEAMARK_BROKER_URL=redis://broker:6379/0 seamark web --host 0.0.0.0 --processes 2
    """
    settings = _settings(data, host=host, port=port)
    from seamark.embedded.web_server import serve

    serve(settings, processes=processes, threads=THREADS, grace_s=GRACE_S)


@click.command()
@click.option("--cores", type=click.IntRange(1, 512), help="Runs at the same time.  [default: all]")
@data_option
def worker(cores: int | None, data: Path | None) -> None:
    """Run a worker only (Celery). The broker's URL comes from SEAMARK_BROKER_URL."""
    _celery(_settings(data, workers=cores), "worker")


@click.command()
@data_option
def beat(data: Path | None) -> None:
    """Run the timer only (Celery beat): it looks for runs of dead workers."""
    _celery(_settings(data), "beat")


def _settings(data: Path | None, **chosen: Any) -> Settings:
    settings = settings_of(data, **chosen)
    if not settings.broker_url:
        raise UsageRefused(
            "SEAMARK_BROKER_URL is not set. `seamark up` brings a broker of its own; single "
            "processes need one that runs, for example redis://localhost:6379/0."
        )
    return settings


def _celery(settings: Settings, part: str) -> None:
    """Become the Celery process."""
    from seamark.worker.service.command_lines import beat_arguments, worker_arguments

    arguments = worker_arguments(settings) if part == "worker" else beat_arguments(settings)
    environ = {k: v for k, v in os.environ.items() if not k.startswith("SEAMARK_")}
    environ |= settings.environment()
    os.execve(sys.executable, [sys.executable, *arguments], environ)  # noqa: S606 (no shell)
