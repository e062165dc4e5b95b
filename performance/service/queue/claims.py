"""Claims a second of 8 and 64 claimers at the same time: `./run performance claims [SECONDS]`.

On one PostgreSQL whose commits wait for the disk (`fsync`). Each claimer is a process with a
connection of its own, as those of workers are. The baseline is a lock that all claims share and
hold until the commit, as earlier versions had.
"""

import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from functools import partial
from multiprocessing import get_context
from multiprocessing.queues import SimpleQueue
from multiprocessing.synchronize import Barrier
from pathlib import Path

from sqlalchemy import func, select, text

from performance.service.database.runs_table import fill
from performance.tables import Row
from performance.tables import text as text_of
from seamark.server.database.engine import Database
from seamark.server.database.result_code import result_code
from seamark.server.database.schema import upgrade
from seamark.server.database.tables import IS_RUNNING, Run, Worker
from seamark.server.messaging import workers
from seamark.server.runs.queue import queue
from seamark.server.runs.record import turns
from seamark.server.settings import Settings
from tests.services import postgres

SECONDS = 10.0
CLAIMERS, OWNERS = (8, 64), (100, 2)
QUEUED = 20_000  # more than are claimed
_SHARED = text("SELECT pg_advisory_xact_lock(1)")
_QUEUE = text(
    "UPDATE runs SET state = 'queued', worker = NULL, lease_until = NULL, started_at = NULL, "
    "owner = 'owner:' || id % :owners"
)
_fork = get_context("fork")


def rows(seconds: float = SECONDS) -> list[Row]:
    """Measure and return a row for each number of claimers and owners."""
    with tempfile.TemporaryDirectory() as folder, postgres.server(durable=True) as server:
        with postgres.database(server.folder, "claims") as url:
            values = {"data": Path(folder), "database_url": url, "running_max": QUEUED}
            settings = Settings.model_validate(values)
            _prepare(settings)
            return list(_measured(settings, seconds))


def _prepare(settings: Settings) -> None:
    upgrade(settings)
    result_code()  # hashes the sources once, before the claimers are forked
    with closing(Database(settings.database_url)) as database:
        fill(database, runs=QUEUED, queued=QUEUED)
        with database.writing() as session:
            place = Worker(name="w", slots=QUEUED, level="none", languages=[], findings=[])
            workers.register(session, place)


def _measured(settings: Settings, seconds: float) -> Iterator[Row]:
    for claimers in CLAIMERS:
        for owners in OWNERS:
            rate, shared = (
                _claims(settings, claimers, owners, seconds, shared=shared)
                for shared in (False, True)
            )
            yield Row(
                what=f"{claimers} claimers, runs of {owners} owners",
                value=rate,
                unit="claims/s",
                baseline="with a lock that all share",
                baseline_value=shared,
            )


def _claims(
    settings: Settings, claimers: int, owners: int, seconds: float, *, shared: bool
) -> float:
    """Return the claims a second of some processes."""
    with closing(Database(settings.database_url)) as database:
        with database.writing() as session:
            session.execute(text("DELETE FROM turns"))
            session.execute(_QUEUE, {"owners": owners})
            turns.rebuild(session)
        ready, counts = _fork.Barrier(claimers), _fork.SimpleQueue()
        what, how = (settings, seconds, ready, counts), {"shared": shared}
        processes = [_fork.Process(target=_claimer, args=what, kwargs=how) for _ in range(claimers)]
        database.close()
        for process in processes:
            process.start()
        claimed: int = sum(counts.get() for _ in processes)
        for process in processes:
            process.join()
        with database.reading() as session:
            if session.scalar(select(func.count()).select_from(Run).where(IS_RUNNING)) != claimed:
                raise RuntimeError("a run was claimed twice, or a claim was lost")
    return claimed / seconds


def _claimer(
    settings: Settings,
    seconds: float,
    ready: Barrier,
    counts: "SimpleQueue[int]",
    *,
    shared: bool,
) -> None:
    claim = partial(queue.try_claim, worker="w/0", languages=(), settings=settings)
    with closing(Database(settings.database_url)) as database:
        count = 0
        ready.wait()
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            if shared:
                with database.writing() as session:
                    session.execute(_SHARED)
                    claimed = claim(session)
            else:
                claimed = queue.claim(database, "w/0", languages=(), settings=settings)
            count += claimed is not None
    counts.put(count)


def main(arguments: Sequence[str]) -> int:
    """Measure with these arguments and print."""
    print(text_of(rows(*map(float, arguments))))
    return 0
