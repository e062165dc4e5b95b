"""The service as `seamark up` starts it, and what it prints."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sqlalchemy import select

from seamark.server.database.engine import Database
from seamark.server.database.tables import Run, User
from seamark.server.runs.ending import results
from seamark.server.runs.record.states import LIVE
from seamark.worker.service.command_line import ONE_THREAD

END_S = 60.0  # most that a service takes to end


@contextmanager
def started(data: Path, **settings: str) -> Iterator[tuple[str, "subprocess.Popen[str]"]]:
    """Serve a data folder with one worker; gives the address and the process.

    `./run test` limits the threads of NumPy, but who starts a service has limited nothing.
    """
    environ = {k: v for k, v in os.environ.items() if not k.startswith("SEAMARK_")}
    for name in ONE_THREAD:
        environ.pop(name, None)
    service = subprocess.Popen(
        up(data),
        env=environ | {f"SEAMARK_{name.upper()}": value for name, value in settings.items()},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        yield address_of(service), service
    finally:
        service.terminate()
        service.communicate(timeout=END_S)


def up(data: Path) -> list[str]:
    """Return the command that serves a data folder on a free port."""
    command = [sys.executable, "-m", "seamark.cli.main", "up", "--port", "0", "--json"]
    return [*command, "--workers", "1", "--data", str(data)]


def address_of(service: "subprocess.Popen[str]") -> str:
    """Return the address of a service that starts, once it is ready."""
    assert service.stdout is not None
    lines = []
    for line in service.stdout:
        lines.append(line)
        if line.startswith("}"):
            break
    address: str = json.loads("".join(lines))["address"]
    return address


def cancel_baselines(database: Database) -> None:
    """Cancel the runs of the built-in entries, which would keep the workers busy for minutes."""
    live = (
        select(Run.id)
        .join(User, User.id == Run.user_id)
        .where(User.is_baseline, Run.state.in_(LIVE))
    )
    with database.writing() as session:
        for run_id in session.scalars(live).all():
            results.cancel(session, run_id)
