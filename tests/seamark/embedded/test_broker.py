"""The broker that `seamark up` starts."""

import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from redis import Redis
from redis.exceptions import OutOfMemoryError

from seamark.embedded import broker


@contextmanager
def started(state: Path, *options: str) -> Iterator[Path]:
    """Yield the socket of the embedded broker on a folder."""
    with tempfile.TemporaryDirectory(prefix="vk") as folder:  # the path of a socket must be short
        socket = Path(folder) / "broker.sock"
        command = [*broker.command(broker.find_server(), socket=socket, state=state), *options]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as server:
            try:
                while not socket.exists():
                    assert server.poll() is None
                yield socket
            finally:
                server.terminate()


def test_live_events_that_an_earlier_version_left_do_not_keep_the_broker_from_taking_tickets(
    tmp_path: Path,
) -> None:
    with (
        started(tmp_path, "--maxmemory", "0") as socket,
        Redis(unix_socket_path=str(socket)) as old,
    ):
        for run in range(3):
            old.xadd(f"run:{run}", {"data": b"x" * 1_000_000})
        old.rpush("runs", "a ticket")

    with started(tmp_path, "--maxmemory", "3mb") as socket:
        with Redis(unix_socket_path=str(socket)) as client:
            with pytest.raises(OutOfMemoryError):
                client.rpush("runs", "refused")
            assert broker.discard_streams(socket) == 3
            client.rpush("runs", "another ticket")
            assert client.lrange("runs", 0, -1) == [b"a ticket", b"another ticket"]
