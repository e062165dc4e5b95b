"""What a run costs each part of the service, and what follows.

Runs that simulate nothing pass the real queue on PostgreSQL and Valkey; the CPU times are those of
the servers' processes. What many workers need is an estimate from these figures.
"""

import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from sqlalchemy import text

from performance.service.queue import start_latency
from performance.service.queue.fake_runs import UNLIMITED, FakeQueue, fake_worker
from seamark.sandbox.isolation import proc_stats
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.schema import upgrade
from seamark.server.runs.queue import lost_attempts, queue
from seamark.server.runs.queue.queue import Claim
from seamark.server.settings import Settings
from tests.services import postgres, valkey

RUNS, CLAIMS, BENCHMARK = 2000, 100, "currents-v2"
WORKERS = (1, 10, 100, 1000)
SLOTS, RUN_S = 2, 10.0  # of a worker in the model; how long its average run takes [s]
SETTLED_S = 12.0  # until each process of a worker has asked the database once


@dataclass(frozen=True, slots=True)
class Used:
    """What database and broker have used since they started."""

    database_s: float  # [s] of CPU time
    wal_bytes: float
    stored_bytes: float
    broker_s: float  # [s] of CPU time
    broker_bytes: float  # received and sent
    commands: float

    def since(self, before: Self, times: int) -> "Used":
        """Return what was used since, divided by a number of times."""
        names = self.__slots__
        return Used(**{n: (getattr(self, n) - getattr(before, n)) / times for n in names})


class Servers(FakeQueue):
    """A database and a broker of their own, and a service on them."""

    def __init__(self, settings: Settings, held: ExitStack, postgres_pid: int) -> None:
        super().__init__(settings, held)
        self._postgres_pid = postgres_pid

    def used(self) -> Used:
        """Return what they have used by now."""
        info = self.redis.info()
        query = "SELECT pg_current_wal_lsn() - '0/0', pg_database_size(current_database())"
        with self.database.reading() as session:
            wal, stored = session.execute(text(query)).one()
        return Used(
            database_s=proc_stats.cpu_s(proc_stats.tree(self._postgres_pid)),
            wal_bytes=float(wal),
            stored_bytes=float(stored),
            broker_s=info["used_cpu_user"] + info["used_cpu_sys"],
            broker_bytes=info["total_net_input_bytes"] + info["total_net_output_bytes"],
            commands=info["total_commands_processed"],
        )

    def connections(self) -> tuple[int, int]:
        """Return how many connections database and broker have beside those of this process."""
        query = "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database()"
        with self.database.reading() as session:
            to_database: int = session.execute(text(query)).scalar_one()
        return to_database - 1, len(self.redis.client_list()) - 1


@dataclass(frozen=True, slots=True)
class Costs:
    """What one of each costs."""

    submission: Used
    submitting_s: float  # [s] CPU of the process that submits
    run: Used
    worker_s: float  # [s] CPU of the worker beside the simulation
    heartbeat: Used
    claim_s: float  # [s] during which no other run can be claimed
    sweep_s: float  # the same of a look for dead workers
    connections: tuple[int, int]  # of a worker with two slots: to the database, to the broker


@contextmanager
def servers() -> Iterator[Servers]:
    """Start database and broker."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        server = stack.enter_context(postgres.server())
        values = {
            "data": folder,
            "database_url": stack.enter_context(postgres.database(server.folder, "load")),
            "broker_url": stack.enter_context(valkey.on_port()),
            "workers": SLOTS,
        }
        settings = Settings.model_validate(values | UNLIMITED)
        upgrade(settings)
        if server.pid is None:
            raise RuntimeError("PostgreSQL has ended")
        yield Servers(settings, stack, server.pid)


def measure(runs: int = RUNS) -> Costs:
    """Measure what one of each costs."""
    with servers() as here:
        connections = _connections(here)
    with servers() as here:
        with fake_worker(here.settings) as worker:
            here.await_worker()
            here.sign_up()
            before, own = here.used(), time.process_time()
            here.submit(runs, BENCHMARK)
            submitting_s = (time.process_time() - own) / runs
            submitted, worked = here.used(), proc_stats.cpu_s(proc_stats.tree(worker.pid))
            here.runs_s(runs)
            done = here.used()
            worked = proc_stats.cpu_s(proc_stats.tree(worker.pid)) - worked
        claims, claim_s = _claims(here, CLAIMS)
        held = here.used()
        for _ in range(10):
            _renew(here, claims)
        return Costs(
            submission=submitted.since(before, runs),
            submitting_s=submitting_s,
            run=done.since(submitted, runs),
            worker_s=worked / runs,
            heartbeat=here.used().since(held, 10 * len(claims)),
            claim_s=claim_s,
            sweep_s=_sweep_s(here),
            connections=connections,
        )


def table(runs: int = RUNS) -> str:
    """Return what was measured, and what many workers need."""
    return f"{measured(costs := measure(runs))}\n\n{estimated(costs)}"


def measured(costs: Costs) -> str:
    """Return the costs as a table."""
    head = ("", "database CPU ms", "WAL KB", "stored KB", "broker CPU ms", "broker KB", "commands")
    lines = [f"{head[0]:<12}" + "".join(f"{name:>17}" for name in head[1:])]
    for name in ("submission", "run", "heartbeat"):
        used: Used = getattr(costs, name)
        values = (
            *(1e3 * used.database_s, used.wal_bytes / 1e3, used.stored_bytes / 1e3),
            *(1e3 * used.broker_s, used.broker_bytes / 1e3, used.commands),
        )
        lines.append(f"{name:<12}" + "".join(f"{value:17.3g}" for value in values))
    to_database, to_broker = costs.connections
    return "\n".join(
        [
            *lines,
            f"CPU of the process that submits {1e3 * costs.submitting_s:.3g} ms, "
            f"of the worker beside the simulation {1e3 * costs.worker_s:.3g} ms",
            f"a claim takes {1e3 * costs.claim_s:.3g} ms, a sweep {1e3 * costs.sweep_s:.3g} ms",
            f"connections of a worker with {SLOTS} slots: {to_database} to the database, "
            f"{to_broker} to the broker",
        ]
    )


def estimated(costs: Costs) -> str:
    """Return what many workers need, if all their slots are busy, as a table."""
    lines = [
        f"Estimate for workers with {SLOTS} slots, all busy, an average run of {RUN_S:g} s:",
        f"{'workers':>8}{'runs/day':>12}{'database cores':>16}{'broker cores':>14}"
        f"{'WAL MB/s':>10}{'database conns':>16}{'broker conns':>14}",
    ]
    settings = Settings.model_validate({})
    for workers in WORKERS:
        rate = workers * SLOTS / RUN_S
        beats = workers * SLOTS / settings.heartbeat_s

        def total(name: str, rate: float = rate, beats: float = beats) -> float:
            once: float = getattr(costs.submission, name) + getattr(costs.run, name)
            often: float = getattr(costs.heartbeat, name)
            return rate * once + beats * often

        lines.append(
            f"{workers:8}{86_400 * rate:12,.0f}{total('database_s'):16.3g}"
            f"{total('broker_s'):14.3g}{total('wal_bytes') / 1e6:10.3g}"
            f"{workers * costs.connections[0]:16,}{workers * costs.connections[1]:14,}"
        )
    return "\n".join(lines)


def _connections(here: Servers) -> tuple[int, int]:
    """Return the connections of a real worker, when each of its processes has had something."""
    with start_latency.real_worker(here.settings):
        with here.database.writing() as session:
            user = accounts.sign_up(session, "ann", None)
            viewer = Viewer(user_id=user.id, name=user.name)
        for _ in range(2 * SLOTS):
            start_latency.evaluate(here.database, here.settings, viewer, None)
        time.sleep(SETTLED_S)
        return here.connections()


def _claims(here: Servers, number: int) -> tuple[list[Claim], float]:
    """Claim runs one by one; return them and the median time of a claim [s]."""
    here.submit(number, BENCHMARK)
    claims, times = [], []
    for _ in range(number):
        begin = time.perf_counter()
        claim = queue.claim(here.database, "load/1", languages=(), settings=here.settings)
        times.append(time.perf_counter() - begin)
        if claim is None:
            raise RuntimeError("no run was claimed")
        claims.append(claim)
    return claims, statistics.median(times)


def _renew(here: Servers, claims: list[Claim]) -> None:
    for claim in claims:
        with here.database.writing() as session:
            queue.heartbeat(session, claim, progress=0.5, t_simulated=1.0, isolation=None)


def _sweep_s(here: Servers) -> float:
    times = []
    for _ in range(50):
        begin = time.perf_counter()
        with here.database.writing() as session:
            lost_attempts.recover(session, {}, here.settings)
            lost_attempts.tidy(session)
        times.append(time.perf_counter() - begin)
    return statistics.median(times)
