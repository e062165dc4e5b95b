"""Programs that are connected by rosbridge, and their neighbours.

How long a control step takes, here and on a server, beside a message that a WebSocket server sends
back; and how long the API takes while a program is connected that behaves, one that sends as much
as it can, and one that wants the whole image of each step. Wall times.
"""

import asyncio
import json
import statistics
import subprocess
import tempfile
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from performance.interoperability.bridges import WAITING
from performance.interoperability.steps import SEAMARK, new_token
from performance.tables import Row
from tests.services.embedded import started

STEPS = 2000
LONG = {"levels": [0.1, 0.2], "level_duration_s": 600.0, "settle_s": 1.0, "tracker": "truth"}
ANSWER = json.dumps(
    {"op": "publish", "topic": "/cmd_vel", "msg": {"linear": {"x": 0.0, "y": 0.0, "z": 0.0}}}
)
REQUESTS = 300
OBSERVED = "/api/v1/benchmarks"


def rows() -> list[Row]:
    """Measure and return the rows."""
    with _echoing() as url, _connected(url) as socket:
        bare = _step_us(socket)
    with _behind_bridge() as url, _connected(url) as socket:
        _subscribe(socket, "/seamark/error")
        here = _step_us(socket)
    with tempfile.TemporaryDirectory() as folder, started(Path(folder)) as (address, _):
        query = f"benchmark=currents-v1&seed=7&config={quote(json.dumps(LONG))}"
        url = f"{address.replace('http', 'ws', 1)}/api/v1/rosbridge?{query}"
        headers = {"Authorization": f"Bearer {new_token(Path(folder))}"}
        alone = _request_ms(address)
        with _connected(url, headers) as socket:
            _subscribe(socket, "/seamark/error")
            there = _step_us(socket)
        beside = {
            name: _beside(address, lambda: _connected(url, headers), behave)
            for name, behave in BEHAVIOURS.items()
        }
    steps = {"on this machine": here, "on a server": there}
    return [
        *(
            Row(what=f"step {name}", value=us, unit="us", baseline="echo", baseline_value=bare)
            for name, us in steps.items()
        ),
        *(
            Row(
                what=f"API beside {name}, {which}",
                value=ms[at],
                unit="ms",
                baseline="alone",
                baseline_value=alone[at],
            )
            for name, ms in beside.items()
            for at, which in enumerate(("p50", "p99"))
        ),
    ]


@contextmanager
def _echoing() -> Iterator[str]:
    """Give the address of a server that sends back what it gets."""
    ready: list[int] = []
    running = threading.Event()
    loop = asyncio.new_event_loop()
    ending = asyncio.Event()

    async def echo(connection: ServerConnection) -> None:
        async for message in connection:
            await connection.send(message)

    async def run() -> None:
        async with serve(echo, "127.0.0.1", 0, compression=None) as server:
            ready.append(next(iter(server.sockets)).getsockname()[1])
            running.set()
            await ending.wait()

    thread = threading.Thread(target=loop.run_until_complete, args=(run(),))
    thread.start()
    running.wait()
    try:
        yield f"ws://127.0.0.1:{ready[0]}"
    finally:
        loop.call_soon_threadsafe(ending.set)
        thread.join()


@contextmanager
def _behind_bridge() -> Iterator[str]:
    """Give the address of `seamark bridge rosbridge`."""
    pairs = [word for name, value in LONG.items() for word in ("--set", f"{name}={_word(value)}")]
    arguments = [*SEAMARK, "bridge", "rosbridge", "currents-v1", *pairs, "--port", "0", "--json"]
    process = subprocess.Popen(
        arguments, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
    )
    try:
        assert process.stderr is not None  # noqa: S101 - it is a pipe
        line = process.stderr.readline()
        yield "ws://127.0.0.1:" + line.removeprefix(WAITING).strip().rstrip(".")
    finally:
        process.kill()
        process.wait()


def _word(value: object) -> str:
    return ",".join(map(str, value)) if isinstance(value, list) else str(value)


@contextmanager
def _connected(url: str, headers: dict[str, str] | None = None) -> Iterator[ClientConnection]:
    """Connect a program; waits for the place that the one before has left."""
    socket = None
    while socket is None:
        try:
            socket = connect(url, additional_headers=headers, compression=None, max_size=None)
        except (OSError, InvalidStatus):
            time.sleep(1.0)
    with socket:
        yield socket


def _subscribe(socket: ClientConnection, topic: str) -> None:
    socket.send(json.dumps({"op": "subscribe", "topic": topic}))
    socket.recv()  # the simulator may have to start first


def _step_us(socket: ClientConnection) -> float:
    """Return the median time from an answer to the next observation [us]."""
    times = []
    for _ in range(STEPS):
        began = time.perf_counter()
        socket.send(ANSWER)
        socket.recv()
        times.append((time.perf_counter() - began) * 1e6)
    return statistics.median(times)


def _request_ms(address: str) -> tuple[float, float]:
    """Return median and p99 of the time that a request takes [ms]."""
    times = []
    for _ in range(REQUESTS):
        began = time.perf_counter()
        with urllib.request.urlopen(f"{address}{OBSERVED}") as answer:  # noqa: S310 - our own
            answer.read()
        times.append((time.perf_counter() - began) * 1e3)
    times.sort()
    return times[REQUESTS // 2], times[REQUESTS * 99 // 100]


def _answer(socket: ClientConnection) -> None:
    _subscribe(socket, "/seamark/error")
    while True:
        socket.send(ANSWER)
        socket.recv()


def _look(socket: ClientConnection) -> None:
    _subscribe(socket, "/seamark/image")
    while True:
        socket.send(ANSWER)
        socket.recv()


def _flood(size: int) -> Callable[[ClientConnection], None]:
    message = json.dumps({"op": "publish", "topic": "/nothing", "msg": {"data": "x" * size}})

    def send(socket: ClientConnection) -> None:
        _subscribe(socket, "/seamark/error")
        threading.Thread(target=_drain, args=(socket,), daemon=True).start()
        while True:
            socket.send(message)

    return send


def _drain(socket: ClientConnection) -> None:
    with suppress(ConnectionClosed):
        for _ in socket:
            pass


BEHAVIOURS: dict[str, Callable[[ClientConnection], None]] = {
    "a program that answers": _answer,
    "one that wants each image": _look,
    "one that floods with small messages": _flood(10),
    "one that floods with large messages": _flood(60_000),
}


def _beside(
    address: str, connecting: Callable[[], Any], behave: Callable[[ClientConnection], None]
) -> tuple[float, float]:
    """Return `_request_ms` while a program behaves in a way."""
    with connecting() as socket:

        def run() -> None:
            with suppress(ConnectionClosed):
                behave(socket)

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        time.sleep(3.0)
        found = _request_ms(address)
        socket.close()
        thread.join()
    return found
