"""Pages beside live streams, slow clients and a large body.

Starts the embedded service, submits a long run and follows it with many viewers. Page requests are
timed by another process; those without streams, in the same service and minute, are the baseline.
"""

import asyncio
import statistics
import tempfile
import time
from collections.abc import AsyncIterator, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass, replace
from http.client import HTTPConnection
from multiprocessing import get_context
from pathlib import Path

from performance.tables import aligned
from seamark.client import Client
from seamark.server.accounts import accounts
from seamark.server.database.engine import Database
from tests.services.embedded import started

VIEWERS = (10, 50, 200)
SLOW = 300  # connections that send a byte every five seconds
SLOW_PERIOD_S = 5.0
LARGE_BYTES = 2**30
MEASURED_S = 15.0
PAUSE_S = 0.01  # between two page requests
# Four levels of 600 s in ten trials: minutes of a simulator that is 250 times as fast as real time.
RUN = {"levels": [0.0, 0.1, 0.2, 0.3], "level_duration_s": 600.0}
TRIALS = 10
HEAD = "POST /api/v1/runs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
COLUMNS = ("beside", "p50 ms", "p99 ms", "x p99 alone", "web MB", "KB to start", "KB/s a viewer")


@dataclass(frozen=True)
class Service:
    """A running service with a run that is computed."""

    port: int
    pid: int
    run_id: int
    token: str

    def request(self, path: str, method: str = "GET") -> bytes:
        """Return a request of this user."""
        lines = (
            f"{method} {path} HTTP/1.1",
            "Host: localhost",
            f"Authorization: Bearer {self.token}",
        )
        return ("\r\n".join(lines) + "\r\n\r\n").encode()

    def with_new_run(self) -> "Service":
        """Return the service with a run that has just begun, in place of the one before."""
        connection = HTTPConnection("127.0.0.1", self.port)
        headers = {"Authorization": f"Bearer {self.token}"}
        connection.request("POST", f"/api/v1/runs/{self.run_id}/cancel", headers=headers)
        connection.getresponse().read()
        connection.close()
        with Client(f"http://127.0.0.1:{self.port}", self.token) as client:
            return replace(self, run_id=_start_run(client))

    def web_bytes(self) -> int:
        """Return the memory of all web processes, shared pages counted once."""
        return sum(_pss(pid) for pid in _web_processes(self.pid))


@dataclass
class Received:
    """What viewers have received."""

    viewers: int
    started: int = 0  # [byte] until each had seen the run so far
    total: int = 0


@contextmanager
def service() -> Iterator[Service]:
    """Start the embedded service and a run."""
    with tempfile.TemporaryDirectory(prefix="seamark-streams-") as folder:
        data = Path(folder) / "data"
        with started(data) as (address, service):
            token = _token(data)
            with Client(address, token) as client:
                run_id = _start_run(client)
            yield Service(int(address.rsplit(":", 1)[1].strip("/")), service.pid, run_id, token)


def _token(data: Path) -> str:
    database = Database(f"sqlite:///{data / 'seamark.db'}")
    try:
        with database.writing() as session:
            user = accounts.sign_up(session, "viewer", None)
            return accounts.new_token(session, user.id, "performance", ("read", "submit"))
    finally:
        database.close()


def _start_run(client: Client) -> int:
    run = client.submit("currents-v1", controller="pi", config=RUN, trials=TRIALS)
    while run.refresh().state == "queued":
        time.sleep(0.5)
    return run.id


def _web_processes(pid: int) -> list[int]:
    """Return the web server's process and all below it."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    for child in map(int, children):
        if Path(f"/proc/{child}/cmdline").read_bytes().split(b"\0")[-2:-1] == [b"web"]:
            return [child, *_below(child)]
    raise RuntimeError("there is no web process")


def _below(pid: int) -> list[int]:
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [process for child in map(int, children) for process in (child, *_below(child))]


def _pss(pid: int) -> int:
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    (kib,) = (int(line.split()[1]) for line in lines if line.startswith("Pss:"))
    return 1024 * kib


def page_times_ms(port: int, paths: tuple[str, ...], token: str, seconds: float) -> list[float]:
    """Return how long pages take [ms], requested one after the other on one connection."""
    connection = HTTPConnection("127.0.0.1", port, timeout=60)
    headers = {"Authorization": f"Bearer {token}"}
    times_ms = []
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        for path in paths:
            start = time.perf_counter()
            connection.request("GET", path, headers=headers)
            answer = connection.getresponse()
            answer.read()
            times_ms.append(1e3 * (time.perf_counter() - start))
            if answer.status != 200:
                raise RuntimeError(f"{path}: {answer.status}")
            time.sleep(PAUSE_S)
    connection.close()
    return times_ms


@asynccontextmanager
async def viewers(service: Service, count: int) -> AsyncIterator[Received]:
    """Follow the run with many viewers."""
    received = Received(count)
    request = service.request(f"/api/v1/runs/{service.run_id}/events")

    async def watch() -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", service.port, limit=2**20)
        writer.write(request)
        start = await reader.readuntil(b"event: telemetry\n")
        received.started += len(start) + len(await reader.readuntil(b"\n\n"))
        while data := await reader.read(65536):
            received.total += len(data)

    tasks = [asyncio.create_task(watch()) for _ in range(count)]
    await asyncio.sleep(3.0 if count else 0.0)
    try:
        yield received
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


@asynccontextmanager
async def _slow(service: Service, count: int, start: str) -> AsyncIterator[None]:
    """Send requests byte by byte."""

    async def dawdle() -> None:
        while True:  # the server gives up on such a client; it comes again
            _, writer = await asyncio.open_connection("127.0.0.1", service.port)
            writer.write(start.encode())
            try:
                while True:
                    await asyncio.sleep(SLOW_PERIOD_S)
                    writer.write(b"x")
                    await writer.drain()
            except OSError:
                writer.close()

    tasks = [asyncio.create_task(dawdle()) for _ in range(count)]
    await asyncio.sleep(2.0)
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


@asynccontextmanager
async def _large_bodies(service: Service) -> AsyncIterator[None]:
    """Send bodies of 1 GB, one after the other."""

    async def send() -> None:
        while True:
            _, writer = await asyncio.open_connection("127.0.0.1", service.port)
            writer.write(f"{HEAD}Content-Length: {LARGE_BYTES}\r\n\r\n".encode())
            try:
                for _ in range(LARGE_BYTES // 2**20):
                    writer.write(bytes(2**20))
                    await writer.drain()
            except OSError:
                pass
            writer.close()

    task = asyncio.create_task(send())
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


class Measurement:
    """Times pages in another process and keeps the lines of the table."""

    def __init__(self, service: Service, pool: ProcessPoolExecutor) -> None:
        self._service, self._pool = service, pool
        self._alone_ms = 0.0
        self.lines: list[tuple[str, ...]] = []

    async def add(self, beside: str, received: Received | None = None) -> None:
        """Measure for a while and add a line."""
        paths = ("/api/v1/benchmarks", f"/api/v1/runs/{self._service.run_id}", "/")
        before = received.total if received else 0
        started = time.monotonic()
        arguments = (self._service.port, paths, self._service.token, MEASURED_S)
        measured = await asyncio.get_running_loop().run_in_executor(
            self._pool, page_times_ms, *arguments
        )
        seconds = time.monotonic() - started
        p99 = statistics.quantiles(measured, n=100)[98]
        self._alone_ms = self._alone_ms or p99
        viewed = ("", "")
        if received:
            rate = (received.total - before) / seconds / received.viewers
            viewed = (f"{received.started / received.viewers / 1e3:.1f}", f"{rate / 1e3:.1f}")
        times = (f"{statistics.median(measured):.1f}", f"{p99:.1f}", f"{p99 / self._alone_ms:.1f}")
        self.lines.append((beside, *times, f"{self._service.web_bytes() / 1e6:.0f}", *viewed))


async def _measure(service: Service, pool: ProcessPoolExecutor) -> list[tuple[str, ...]]:
    measurement = Measurement(service, pool)
    await measurement.add("nothing")
    for count in VIEWERS:
        watched = await asyncio.to_thread(service.with_new_run)  # else it might end meanwhile
        async with viewers(watched, count) as received:
            await measurement.add(f"{count} viewers", received)
    for part, start in (("heads", HEAD), ("bodies", f"{HEAD}Content-Length: 1000\r\n\r\n")):
        async with _slow(service, SLOW, start):
            await measurement.add(f"{SLOW} slow {part}")
    async with _large_bodies(service):
        await measurement.add("bodies of 1 GB, one after the other")
    await measurement.add("nothing again")
    return measurement.lines


def table() -> str:
    """Return the table."""
    with service() as running, ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        lines = [COLUMNS, *asyncio.run(_measure(running, pool))]
    return aligned(lines)
