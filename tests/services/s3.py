"""An S3 server for the tests: that of moto, which keeps objects in memory."""

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import httpx

from tests.services.ports import free_port
from tests.services.processes import end

START_S = 60.0


class Server:
    """A server with one empty bucket; it can be stopped for a while without losing objects."""

    def __init__(self) -> None:
        port = free_port()
        self.endpoint = f"http://127.0.0.1:{port}"
        command = [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(port)]
        self.process = subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self._make_bucket("seamark")

    def settings(self, prefix: str) -> dict[str, str]:
        """Return the settings of a service that keeps its data here."""
        return {
            "storage_url": f"s3://seamark/{prefix}",
            "storage_endpoint": self.endpoint,
            "storage_access_key": "tests",
            "storage_secret_key": "only-for-tests",
        }

    def _make_bucket(self, name: str) -> None:
        deadline = time.monotonic() + START_S
        while True:
            try:
                httpx.put(f"{self.endpoint}/{name}", timeout=START_S).raise_for_status()
                return
            except httpx.TransportError:
                assert time.monotonic() < deadline, "the S3 server does not answer"
                time.sleep(0.05)  # it does not announce that it listens


@contextmanager
def server() -> Iterator[Server]:
    """Yield a new server."""
    made = Server()
    try:
        yield made
    finally:
        end(made.process, 10.0)
