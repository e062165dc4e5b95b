"""A private Valkey server for the tests: the one that `seamark up` starts."""

import subprocess
import tempfile
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from redis import Redis
from redis.exceptions import RedisError

from seamark.embedded.broker import find_server
from seamark.server.messaging import live_events
from tests.services.ports import free_port


@contextmanager
def on_socket() -> Iterator[str]:
    """Yield the unix:// URL of a new server."""
    with tempfile.TemporaryDirectory(prefix="vk") as folder:  # the path of a socket must be short
        path = f"{folder}/v.sock"
        with _serve(folder, "--port", "0", "--unixsocket", path, "--unixsocketperm", "700"):
            _wait_until_ready(Redis(unix_socket_path=path))
            yield f"unix://{path}"


@contextmanager
def on_port() -> Iterator[str]:
    """Yield the redis:// URL of a new server on the loopback interface."""
    port = free_port()
    with tempfile.TemporaryDirectory(prefix="vk") as folder:
        with _serve(folder, "--port", str(port), "--bind", "127.0.0.1"):
            _wait_until_ready(Redis(port=port))
            yield f"redis://127.0.0.1:{port}/0"


@contextmanager
def _serve(folder: str, *arguments: str) -> Iterator[None]:
    command = [str(find_server()), "--save", "", "--appendonly", "no", "--dir", folder, *arguments]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as server:
        try:
            yield
        finally:
            server.terminate()


def _wait_until_ready(client: Redis) -> None:
    deadline = time.monotonic() + 10
    while True:
        try:
            client.ping()
            client.close()
            return
        except RedisError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.01)  # a server does not announce that it listens


MARK = b"mark "


class Listener:
    """Receives what is published about the states of runs."""

    def __init__(self, client: Redis) -> None:
        self._client = client
        self._channel = client.pubsub()  # type: ignore[no-untyped-call]
        self._channel.subscribe(live_events.CHANNEL)
        self._channel.get_message(timeout=10)  # that it has subscribed

    def states(self) -> list[tuple[int, dict[str, Any]]]:
        """Return runs and states that were published since the last call."""
        mark = MARK + uuid.uuid4().hex.encode()
        self._client.publish(live_events.CHANNEL, mark)
        found: list[tuple[int, dict[str, Any]]] = []
        while (message := self._channel.get_message(timeout=10)) is not None:
            if message["data"] == mark:
                return found
            if not message["data"].startswith(MARK):  # of another listener
                found.append(live_events.parse(message["data"]))
        raise TimeoutError("the broker does not deliver what is published")


@contextmanager
def listening(url: str) -> Iterator[Listener]:
    """Yield a listener."""
    with Redis.from_url(url) as client:
        yield Listener(client)
