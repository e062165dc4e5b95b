"""How long after a worker has written a row a viewer receives it.

On two machines that share S3, Valkey and a database, but no folder. The worker writes a row every
20 ms; the baseline is a service whose broker is away, so that viewers have the stored parts alone.
"""

import asyncio
import statistics
import tempfile
import threading
import time
from bisect import bisect_left
from contextlib import closing, suppress
from pathlib import Path

from performance.tables import Row
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.web.streams.hub import Hub
from tests.cast import Backend
from tests.services import s3, valkey
from tests.services.machines import Machines, numbered_rows
from tests.services.viewer import Viewer, parsed

SETTLE_S = 6.0  # until the viewers have joined and the first parts are stored
MEASURED_S = 20.0
ROW_EVERY_S = 0.02
VIEWERS = 20
NOWHERE = "unix:///nothing/here"


def rows() -> list[Row]:
    """Measure and return the rows."""
    with s3.server() as storage, valkey.on_port() as broker_url:
        live = _lags_s(storage.settings("live"), broker_url)
        stored = _lags_s(storage.settings("stored"), NOWHERE)
    return [
        Row(
            what=f"from a written row to its viewers, {name}",
            value=live[at] * 1e3,
            unit="ms",
            baseline="by stored parts",
            baseline_value=stored[at] * 1e3,
        )
        for name, at in (("median", 49), ("p99", 98))
    ]


class _Worker:
    """Writes rows in a thread and remembers when."""

    def __init__(self, machines: Machines, run_id: int, attempt: int) -> None:
        self.written_at = list[float]()  # of each row, monotonic
        self._files, self._upload = machines.recording(run_id, attempt)
        self._thread = threading.Thread(target=self._write)
        self._thread.start()

    def _write(self) -> None:
        for row in range(int((SETTLE_S + MEASURED_S) / ROW_EVERY_S)):
            self._files.append_rows(numbered_rows(row, 1))
            self.written_at.append(time.monotonic())
            time.sleep(ROW_EVERY_S)

    async def end(self) -> None:
        """Wait until all rows are written."""
        await asyncio.to_thread(self._thread.join)
        self._upload.stop()


def _lags_s(storage: dict[str, str], broker_url: str) -> list[float]:
    """Return 99 percentiles of the lag [s]."""
    with tempfile.TemporaryDirectory() as folder:
        places = {"database_url": f"sqlite:///{folder}/seamark.db", "broker_url": broker_url}
        machines = Machines(Path(folder), storage | places)
        upgrade(machines.web)
        with closing(Database(machines.web.database_url)) as database:
            return statistics.quantiles(asyncio.run(_measured(machines, database)), n=100)


async def _measured(machines: Machines, database: Database) -> list[float]:
    claim = Backend.with_cast(database, machines.web).running("ann")
    hub = Hub(database, machines.web)
    worker = _Worker(machines, claim.run_id, claim.attempt)
    received = list[tuple[float, float]]()  # simulated time of the newest row, and when it came
    viewers = [Viewer(hub, claim.run_id).watch() for _ in range(VIEWERS - 1)]
    tasks = [asyncio.create_task(one) for one in (_receive(hub, claim.run_id, received), *viewers)]
    await worker.end()
    for task in tasks:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task
    hub.close()
    first = int(SETTLE_S / ROW_EVERY_S)
    newest = [t for t, _ in received]
    # The rows of a stream are thinned: a viewer has a row when he has it or a later one.
    shown = [bisect_left(newest, 0.05 * row - 1e-6) for row in range(len(worker.written_at))]
    return [
        received[at][1] - worker.written_at[row]
        for row, at in enumerate(shown)
        if row >= first and at < len(received)
    ]


async def _receive(hub: Hub, run_id: int, received: list[tuple[float, float]]) -> None:
    gone = asyncio.get_running_loop().create_future()
    stream = hub.follow(run_id, None, shows_log=True, gone=gone, abort=lambda: None)
    async for piece in stream:
        now = time.monotonic()
        for kind, _, data in parsed(piece):
            if kind == "telemetry":
                received.append((data["rows"][-1][data["columns"].index("t")], now))
