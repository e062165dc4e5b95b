"""The real web server of `seamark web` as a process, and connections that try its patience."""

import os
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from seamark.server.settings import Settings
from tests.services.ports import free_port
from tests.services.processes import end

START_S = 120.0


@dataclass(frozen=True)
class WebServer:
    """A running web server."""

    port: int
    process: "subprocess.Popen[bytes]"
    log: Path

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def connect(self) -> socket.socket:
        return socket.create_connection(("127.0.0.1", self.port), timeout=60)

    def get(self, path: str, timeout: float = 60.0) -> bytes:
        address = f"{self.url}{path}"
        with urllib.request.urlopen(address, timeout=timeout) as answer:  # noqa: S310 - our own
            body: bytes = answer.read()
            return body

    def restart_processes(self) -> None:
        """Replace the web processes one after the other, as after an update."""
        self.process.send_signal(signal.SIGHUP)


@contextmanager
def serving(
    settings: Settings, *, processes: int = 1, files: int | None = None
) -> Iterator[WebServer]:
    """Serve the database of `settings` on a free port, with a limit of open files if wanted."""
    port, log = free_port(), settings.data / "web.log"
    command = [sys.executable, "-m", "seamark.cli.main", "web", "--port", str(port)]
    if files is not None:
        command = ["sh", "-c", f'ulimit -n {files}; exec "$@"', "sh", *command]
    with log.open("wb") as written:
        process = subprocess.Popen(
            [*command, "--processes", str(processes)],
            env=os.environ | settings.environment(),
            stderr=written,
        )
    try:
        server = WebServer(port, process, log)
        _wait_until_it_answers(server)
        yield server
    finally:
        end(process, 20.0)


@contextmanager
def slow_connections(server: WebServer, count: int, start: bytes) -> Iterator[list[socket.socket]]:
    """Hold connections open that have sent the start of a request and nothing more."""
    with ExitStack() as stack:
        opened = [stack.enter_context(closing(server.connect())) for _ in range(count)]
        for connection in opened:
            connection.sendall(start)
        yield opened


def _wait_until_it_answers(server: WebServer) -> None:
    deadline = time.monotonic() + START_S
    while server.process.poll() is None and time.monotonic() < deadline:
        with suppress(urllib.error.URLError, OSError):
            server.get("/healthz", timeout=5)
            return
        time.sleep(0.05)  # a server does not announce that it listens
    raise TimeoutError(f"the web server does not answer; exit code {server.process.returncode}")
