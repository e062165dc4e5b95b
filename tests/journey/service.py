"""The real service, started by `seamark up`, for a test alone or for all processes of the tests."""

import fcntl
import json
import os
import select
import shutil
import signal
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pytest

from seamark.server.database.engine import Database
from tests.services.embedded import cancel_baselines
from tests.services.ports import free_port

START_S = 240.0
END_S = 30.0
TWO_TRIALS = Path(__file__).with_name("two_trials")


@dataclass(frozen=True)
class Service:
    """A running service."""

    folder: str
    port: int
    embedding_port: int  # of the other site that may show runs in a frame
    process: int

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def data(self) -> Path:
        return Path(self.folder) / "data"


def start(**settings: str) -> Service:
    """Run `seamark up` on a free port, in a folder of its own.

    Not by `subprocess`, whose processes are ended by the process that started them.
    """
    folder = tempfile.mkdtemp(prefix="seamark-journey-")
    port, embedding_port = free_port(), free_port()
    command = [sys.executable, "-m", "seamark.cli.main", "up", "--port", str(port)]
    log = Path(folder) / "log"
    process = os.posix_spawn(
        sys.executable,
        [*command, "--data", f"{folder}/data"],
        {
            **os.environ,
            "SEAMARK_SIGN_UPS_PER_HOUR": "1000",  # all tests sign up from one address
            "SEAMARK_EMBED_ORIGINS": f"http://localhost:{embedding_port}",
            **settings,
        },
        file_actions=[
            (os.POSIX_SPAWN_OPEN, 1, str(log), os.O_WRONLY | os.O_CREAT, 0o600),
            (os.POSIX_SPAWN_DUP2, 1, 2),
        ],
        setsigdef=[signal.SIGPIPE],
    )
    service = Service(folder, port, embedding_port, process)
    try:
        _wait_until_ready(service, log)
    except BaseException:
        end(service)
        raise
    return service


def _wait_until_ready(service: Service, log: Path) -> None:
    deadline = time.monotonic() + START_S
    with _handle(service) as handle:
        while not _is_ready(service.url):
            if _has_ended(handle, 0.2) or time.monotonic() > deadline:
                pytest.fail(f"the service did not start:\n{log.read_text()[-4000:]}")


def _is_ready(url: str) -> bool:
    try:
        with urllib.request.urlopen(f"{url}/readyz", timeout=2) as response:  # noqa: S310 - our own
            return bool(response.status == 200)
    except (urllib.error.URLError, OSError):
        return False


def end(service: Service) -> None:
    """Stop a service, whoever started it; kill it if it has not ended after a while."""
    with _handle(service) as handle:
        os.kill(service.process, signal.SIGTERM)
        if not _has_ended(handle, END_S):
            os.kill(service.process, signal.SIGKILL)
            _has_ended(handle, END_S)
    with suppress(ChildProcessError):  # another process has started it
        os.waitpid(service.process, 0)
    shutil.rmtree(service.folder, ignore_errors=True)


@contextmanager
def _handle(service: Service) -> Iterator[int]:
    """Give a file descriptor that is ready when the service has ended."""
    handle = os.pidfd_open(service.process)
    try:
        yield handle
    finally:
        os.close(handle)


def _has_ended(handle: int, within_s: float) -> bool:
    return select.select([handle], [], [], within_s)[0] != []


@contextmanager
def running(**settings: str) -> Iterator[Service]:
    """Give a service of one's own."""
    service = start(**settings)
    try:
        yield service
    finally:
        end(service)


@contextmanager
def shared(folder: Path) -> Iterator[Service]:
    """Give the service of all processes that name this folder; the last that used it ends it."""
    state = folder / "service.json"
    with (folder / "users").open("w") as users:
        with locked(folder):
            fcntl.flock(users, fcntl.LOCK_SH)
            service = Service(**once(state, lambda: asdict(_start_embedded())))
        yield service
        with locked(folder), suppress(BlockingIOError):
            fcntl.flock(users, fcntl.LOCK_EX | fcntl.LOCK_NB)
            state.unlink()
            end(service)


def once(path: Path, make: Callable[[], Any]) -> Any:
    """Return what a file has as JSON, or make and keep it. Not for two processes at once."""
    if not path.exists():
        path.write_text(json.dumps(make()))
    return json.loads(path.read_text())


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Wait until no other process is in here with the same folder."""
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _start_embedded() -> Service:
    """Start a service with its embedded defaults: SQLite and its own broker.

    Its ranked runs of currents-v1 are short.
    """
    service = start(PYTHONPATH=str(TWO_TRIALS))
    without_baselines(f"sqlite:///{service.data / 'seamark.db'}")
    return service


def without_baselines(database_url: str) -> None:
    """Cancel the runs of the built-in entries of a service."""
    with closing(Database(database_url)) as database:
        cancel_baselines(database)
