"""Pages beside 10,000 unfinished upgrades to a WebSocket.

The requests are those that once had no deadline and no answer. One process opens them as fast as
it can and holds each until the service ends it, while 50 viewers follow a run.
"""

import asyncio
import multiprocessing
import resource
import socket
import time
from collections.abc import AsyncIterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import AsyncExitStack, ExitStack, asynccontextmanager, suppress

from performance.service.web.streams import (
    COLUMNS,
    Measurement,
    Received,
    Service,
    service,
    viewers,
)
from performance.tables import aligned

UPGRADES = 10_000
READERS = 50
HELD_S = 60.0  # most; the measurement is shorter
_HANDSHAKE = (
    "Host: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
)
_LINE = "GET /api/v1/rosbridge HTTP/1.1\r\n"
UNFINISHED = tuple(
    request.encode("latin-1")
    for request in (
        f"GET /api/v1/rosbridge?{'a' * 9000} HTTP/1.1\r\n{_HANDSHAKE}\r\n",
        f"{_LINE}{_HANDSHAKE}X-Long: {'a' * 9000}\r\n\r\n",
        f"{_LINE}{_HANDSHAKE}{''.join(f'X-{at}: a{chr(13)}{chr(10)}' for at in range(130))}\r\n",
        f"{_LINE}{_HANDSHAKE}Content-Length: 3\r\n\r\n",
        f"POST /api/v1/rosbridge HTTP/1.1\r\n{_HANDSHAKE}\r\n",
        f"{_LINE}{_HANDSHAKE}X-Odd: a\x01b\r\n\r\n",
        f"{_LINE}{_HANDSHAKE}",
    )
)


def flood(port: int, opened: "multiprocessing.queues.Queue[float]") -> None:
    """Open the connections and hold them; tell how long opening them took [s]."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    with ExitStack() as stack:
        started = time.monotonic()
        for number in range(UPGRADES):
            with suppress(OSError):
                connection = socket.create_connection(("127.0.0.1", port), timeout=5)
                stack.enter_context(connection)
                connection.sendall(UNFINISHED[number % len(UNFINISHED)])
        opened.put(time.monotonic() - started)
        time.sleep(HELD_S)


@asynccontextmanager
async def _flooded(port: int) -> AsyncIterator["multiprocessing.queues.Queue[float]"]:
    context = multiprocessing.get_context("spawn")
    opened = context.Queue()
    process = context.Process(target=flood, args=(port, opened))
    process.start()
    try:
        yield opened
    finally:
        process.terminate()
        process.join()


@asynccontextmanager
async def _watched(running: Service) -> AsyncIterator[Received]:
    """Follow a run that has just begun with all viewers."""
    watched = await asyncio.to_thread(running.with_new_run)
    async with viewers(watched, READERS) as received:
        yield received


async def _measure(running: Service, pool: ProcessPoolExecutor) -> list[tuple[str, ...]]:
    measurement = Measurement(running, pool)
    async with AsyncExitStack() as flooded:
        async with _watched(running) as received:
            await measurement.add(f"{READERS} viewers", received)
            opened = await flooded.enter_async_context(_flooded(running.port))
            await measurement.add(f"... and {UPGRADES} unfinished upgrades", received)
            seconds = await asyncio.to_thread(opened.get)
        async with _watched(running) as received:  # the first run may have ended
            await measurement.add(f"... opened in {seconds:.1f} s, and held", received)
    async with _watched(running) as received:
        await measurement.add(f"{READERS} viewers again", received)
    return measurement.lines


def table() -> str:
    """Return the table."""
    spawn = multiprocessing.get_context("spawn")
    with service() as running, ProcessPoolExecutor(1, mp_context=spawn) as pool:
        return aligned([COLUMNS, *asyncio.run(_measure(running, pool))])
