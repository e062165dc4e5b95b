"""What a run costs each part of the service, and what follows.

Runs that simulate nothing pass the real queue on PostgreSQL and Valkey; the CPU times are those of
the servers' processes. What many workers need is an estimate from these figures.
"""

import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from redis import Redis
from sqlalchemy import text

from performance.service.queue import start_latency
from performance.service.queue.fake_runs import NOTHING, count, fake_worker, wait
from seamark.sandbox.isolation import proc_stats
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.messaging import broker
from seamark.server.runs.queue import queue
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.record.states import LIVE
from seamark.server.runs.submission import submission
from seamark.server.runs.submission.submission import Submission
from seamark.server.settings import Settings
from tests.services import postgres, valkey

RUNS, CLAIMS, USERS = 2000, 100, 50
WORKERS = (1, 10, 100, 1000)
PLACES, RUN_S = 2, 10.0  # of a worker in the model; how long its average run takes [s]
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


@dataclass(frozen=True, slots=True)
class Servers:
    """A database and a broker of their own, and the settings of a service on them."""

    settings: Settings
    database: Database
    redis: "Redis"
    postgres_pid: int

    def used(self) -> Used:
        """Return what they have used by now."""
        info = self.redis.info()
        query = "SELECT pg_current_wal_lsn() - '0/0', pg_database_size(current_database())"
        with self.database.reading() as session:
            wal, stored = session.execute(text(query)).one()
        return Used(
            database_s=proc_stats.cpu_s(proc_stats.tree(self.postgres_pid)),
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
            found: int = session.execute(text(query)).scalar_one()
        return found - 1, len(self.redis.client_list()) - 1


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
    connections: tuple[int, int]  # of a worker with two places: to the database, to the broker


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
            "workers": PLACES,
            **{"quota_live": 10**6, "quota_day": 10**6, "quota_bytes": 10**15},
        }
        settings = Settings.model_validate(values)
        upgrade(settings)
        database = stack.enter_context(closing(Database(settings.database_url)))
        redis = stack.enter_context(closing(broker.connect(settings)))
        if server.pid is None:
            raise RuntimeError("PostgreSQL has ended")
        yield Servers(settings, database, redis, server.pid)


def measure(runs: int = RUNS) -> Costs:
    """Measure what one of each costs."""
    with servers() as here:
        connections = _connections(here)
    with servers() as here, closing(broker.celery_app(here.settings)) as app:
        worker = fake_worker(here.settings)
        try:
            keys = [*broker.ticket_keys(app), "unacked"]
            app.send_task(NOTHING)
            wait(lambda: not here.redis.exists(*keys))
            before, own = here.used(), time.process_time()
            _submit(here, "first", runs)
            submitting_s = (time.process_time() - own) / runs
            submitted, worked = here.used(), proc_stats.cpu_s(proc_stats.tree(worker.pid))
            broker.send_tickets(app, runs)
            wait(lambda: not count(here.database, *LIVE))
            done = here.used()
            worked = proc_stats.cpu_s(proc_stats.tree(worker.pid)) - worked
        finally:
            worker.terminate()
            worker.wait()
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
            f"connections of a worker with {PLACES} places: {to_database} to the database, "
            f"{to_broker} to the broker",
        ]
    )


def estimated(costs: Costs) -> str:
    """Return what many workers need, if all their places are busy, as a table."""
    lines = [
        f"Estimate for workers with {PLACES} places, all busy, an average run of {RUN_S:g} s:",
        f"{'workers':>8}{'runs/day':>12}{'database cores':>16}{'broker cores':>14}"
        f"{'WAL MB/s':>10}{'database conns':>16}{'broker conns':>14}",
    ]
    settings = Settings.model_validate({})
    for workers in WORKERS:
        rate = workers * PLACES / RUN_S
        beats = workers * PLACES / settings.heartbeat_s

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
        for _ in range(2 * PLACES):
            start_latency.evaluate(here.database, here.settings, viewer, None)
        time.sleep(SETTLED_S)
        return here.connections()


def _submit(here: Servers, name: str, number: int) -> None:
    """Submit runs as the web process does, each in a transaction of its own."""
    with here.database.writing() as session:
        users = [accounts.sign_up(session, f"{name}{index}", None) for index in range(USERS)]
        viewers = [Viewer(user_id=user.id, name=user.name) for user in users]
    for index in range(number):
        viewer = viewers[index % USERS]
        wanted = Submission(viewer=viewer, benchmark="currents-v2", config={}, controller="pi")
        valid = submission.validate(wanted, here.settings)
        with here.database.writing() as session:
            submission.submit(session, valid, here.settings)


def _claims(here: Servers, number: int) -> tuple[list[Claim], float]:
    """Claim runs one by one; return them and the median time of a claim [s]."""
    _submit(here, "second", number)
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
            queue.recover(session, {}, here.settings)
            queue.tidy(session)
        times.append(time.perf_counter() - begin)
    return statistics.median(times)
