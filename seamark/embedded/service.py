"""The embedded service: broker, web server and worker as children of one process."""

from __future__ import annotations

import fcntl
import os
import signal
import socket
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from seamark.embedded import broker
from seamark.embedded.installed_tools import InstalledTools
from seamark.embedded.supervisor import Child, Supervisor
from seamark.embedded.worker_renewal import STEP_EVERY_S, WorkerRenewal
from seamark.failures import PlatformFailed, UsageRefused
from seamark.worker.service.command_line import ONE_THREAD

if TYPE_CHECKING:
    from seamark.server.settings import Settings

PATIENCE_S = 60.0  # [s] after which a start that takes long is said to go on
BROKER_S = 10.0
POLL_S = 0.2  # between two looks at whether the service answers
WORKER_GRACE_S = 20.0  # in which a run that is under way returns to the queue
WEB_GRACE_S = 12.0  # more than the web server gives its requests
_PARTS = {"web": "the web server", "worker": "the worker"}


class Embedded:
    """Starts the service in `settings.data`, waits for the end, ends it.

    Parameters
    ----------
    settings
        With an empty `broker_url` a broker is started too.
    say
        Prints one line for the person at the terminal.
    installer
        File that is locked as long as programs for uploads are being installed on this machine.
    """

    def __init__(
        self, settings: Settings, say: Callable[[str], None], *, installer: Path | None = None
    ) -> None:
        self._settings = settings
        self._installer = installer
        self._say = say
        self._logs = settings.data / "logs"

    def run(
        self,
        on_ready: Callable[[Settings], None],
        *,
        pages_up: Callable[[Settings], None] = lambda _: None,
    ) -> signal.Signals:
        """Start, keep all alive; return the signal that ended it.

        Parameters
        ----------
        on_ready
            Is called when a worker is there, which may still be compiling the simulator.
        pages_up
            Is called when the web server answers, before that.

        Raises
        ------
        UsageRefused
            Another instance uses the data folder, or the port is in use.
        PlatformFailed
            A part of the service did not start.
        """
        with locked(self._settings.data):
            _check_port(self._settings)
            with (
                tempfile.TemporaryDirectory(prefix="seamark-") as socket_folder,
                Supervisor(self._say) as children,
            ):
                settings = self._with_broker(children, Path(socket_folder))
                self._prepare(settings)
                tools = InstalledTools()  # before the worker finds out what there is
                children.add(self._child("web", settings))
                with WorkerRenewal(
                    settings,
                    children,
                    lambda: children.add(self._child("worker", settings)),
                    say=self._say,
                    tools=tools,
                    installer=self._installer,
                ) as renewal:
                    for path, reached in (("healthz", pages_up), ("readyz", on_ready)):
                        stopped = self._wait_until_answered(path, children, settings)
                        if stopped is not None:
                            return stopped
                        reached(settings)
                    return _keep(children, renewal)

    def _with_broker(self, children: Supervisor, socket_folder: Path) -> Settings:
        """Start the broker unless the settings name one; return settings with its URL."""
        if self._settings.broker_url:
            return self._settings
        server = broker.find_server()
        path, state = socket_folder / "broker.sock", self._settings.data / "broker"
        state.mkdir(exist_ok=True, mode=0o700)
        children.add(
            Child(
                name="the broker",
                argv=broker.command(server, socket=path, state=state),
                environ=_bare_environment(),
                log=self._logs / "broker.log",
                stop_order=2,
                grace_s=5.0,
            )
        )
        deadline = time.monotonic() + BROKER_S
        while not _listens(path):
            if time.monotonic() > deadline or children.wait(0.02) is not None:
                raise PlatformFailed(f"The broker did not start. See {self._logs / 'broker.log'}.")
        broker.discard_streams(path)
        return self._settings.model_copy(update={"broker_url": f"unix://{path}"})

    def _prepare(self, settings: Settings) -> None:
        """Bring the database up to date and queue the built-in entries."""
        import logging

        import structlog

        from seamark.server.database import schema
        from seamark.server.database.data_folder import WrongDataFolder
        from seamark.server.database.engine import Database
        from seamark.server.runs.submission import baselines

        quiet = structlog.make_filtering_bound_logger(logging.WARNING)
        structlog.configure(wrapper_class=quiet)  # the terminal is for people
        try:
            schema.upgrade(settings)
        except WrongDataFolder as error:
            raise PlatformFailed(f"{error}.") from None
        database = Database(settings.database_url)
        try:
            with database.writing() as session:
                baselines.ensure(session, settings)
        finally:
            database.close()

    def _child(self, name: str, settings: Settings) -> Child:
        """Return the web server or the worker."""
        return Child(
            name=_PARTS[name],
            argv=[sys.executable, "-s", "-P", "-m", "seamark.cli.main", name],
            environ=_bare_environment() | settings.environment(),
            log=self._logs / f"{name}.log",
            stop_order=1 if name == "worker" else 0,
            grace_s=WORKER_GRACE_S if name == "worker" else WEB_GRACE_S,
        )

    def _wait_until_answered(
        self, path: str, children: Supervisor, settings: Settings
    ) -> signal.Signals | None:
        """Wait until the web server answers for a path; return a stop signal.

        For as long as it takes: a slow machine needs many minutes, and whoever waits can stop it.
        """
        say_at = time.monotonic() + PATIENCE_S
        while True:
            stopped = children.wait(POLL_S)
            if stopped is not None:
                return stopped
            if _answers(f"{address_of(settings)}{path}"):
                return None
            for child in children.children:
                if len(child.exits) >= 3:
                    raise PlatformFailed(_start_failure(child.name, child.log))
            if time.monotonic() > say_at:
                say_at += PATIENCE_S
                self._say(f"The service is still starting. The logs are in {self._logs}.")


def _keep(children: Supervisor, renewal: WorkerRenewal) -> signal.Signals:
    """Keep all alive; return the signal that ended it."""
    while True:
        stopped = children.wait(STEP_EVERY_S)
        if stopped is not None:
            return stopped
        renewal.step()


def address_of(settings: Settings) -> str:
    """Return the address to type into a browser."""
    return f"http://{_reachable(settings.host)}:{settings.port}/"


def _reachable(host: str) -> str:
    if host in ("0.0.0.0", "::", ""):  # noqa: S104 (compared, not bound)
        return "127.0.0.1"
    return f"[{host}]" if ":" in host else host


def _bare_environment() -> dict[str, str]:
    """Return the environment without settings: children get all of them from one object."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("SEAMARK_")}
    return kept | ONE_THREAD | {"PYTHONUNBUFFERED": "1"}


@contextmanager
def locked(data: Path) -> Iterator[None]:
    """Lock the data folder; the kernel drops the lock at a crash."""
    path = data / "up.lock"
    with path.open("a+") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.seek(0)
            owner = lock.read().strip() or "unknown"
            raise UsageRefused(
                f"Seamark is already running on {data} (process {owner}). "
                "Stop it first, or choose another folder with --data."
            ) from None
        lock.truncate(0)
        lock.write(f"{os.getpid()}\n")
        lock.flush()
        yield


def _check_port(settings: Settings) -> None:
    """Refuse a port in use, before anything is started."""
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    with socket.socket(family) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((settings.host, settings.port))
        except (OSError, OverflowError) as error:
            raise UsageRefused(
                f"Cannot listen on {settings.host}:{settings.port}: {error}. "
                "Choose another with --port or --host."
            ) from None


def free_port(host: str) -> int:
    """Return a port that is free now."""
    with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET) as probe:
        probe.bind((host, 0))
        port: int = probe.getsockname()[1]
        return port


def _listens(path: Path) -> bool:
    with socket.socket(socket.AF_UNIX) as probe:
        try:
            probe.connect(str(path))
        except OSError:
            return False
        return True


def _answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=2):  # noqa: S310 (our own address)
            return True
    except (urllib.error.URLError, OSError):
        return False


def _start_failure(name: str, log: Path) -> str:
    lines = log.read_text(errors="replace").splitlines() if log.exists() else []
    last = "\n".join(f"  {line}" for line in lines[-8:])
    return f"{name} does not start. The end of {log}:\n{last}"
