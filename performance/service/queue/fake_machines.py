"""Many runs that simulate nothing, through eight workers on two machines without a shared folder.

`./run machines fake-runs [RUNS]`. Each worker is a container of compose.yaml or compose.worker.yaml
with its settings, rights and secrets; PostgreSQL, Valkey and the S3 server are on the first
machine. The baseline are Celery tasks that do nothing, through the same workers.
"""

import statistics
import sys
from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack, closing

from celery import Celery
from redis import Redis
from sqlalchemy import func, select

from performance.service.queue.fake_runs import (
    CLAIMS,
    COMMAND,
    NOTHING,
    OPTIONS,
    PLACES,
    QUOTAS,
    RUNS,
    count,
    submit_runs,
    timed,
)
from performance.tables import Row, text
from seamark.server.database.engine import Database
from seamark.server.database.tables import Result, Run
from seamark.server.messaging import broker
from seamark.server.runs.record.states import LIVE, RunState
from seamark.server.settings import Settings
from tests.chaos import machine_session
from tests.chaos.installation import wait_until
from tests.chaos.machine_session import ELSEWHERE, HERE, START_S, STORES, Session
from tests.services import compose

PING_S = 5.0
STEPS = ("migrate", "worker-rights")


class Fleet:
    """The workers, and what they share."""

    def __init__(self, session: Session, held: ExitStack) -> None:
        self._session = session
        values = {
            "data": session.host.folder / "measuring",
            "database_url": session.url("database_url"),
            "broker_url": session.url("broker_url"),
            "storage_url": "s3://seamark",
            "storage_endpoint": f"http://{STORES['objects']}:3900",
            "storage_access_key": (session.host.secrets / "storage_access_key").read_text(),
            "storage_secret_key": (session.host.secrets / "storage_secret_key").read_text(),
            "seed_key": (session.host.secrets / "seed_key").read_text(),
        }
        self.settings = Settings.model_validate(values | QUOTAS)
        self.database = held.enter_context(closing(Database(self.settings.database_url)))
        self.app: Celery = held.enter_context(closing(broker.celery_app(self.settings)))
        self.redis: Redis = held.enter_context(closing(broker.connect(self.settings)))

    def start(self) -> None:
        """Start the workers, half of them on each machine, and wait for all."""
        inside = {"PYTHONPATH": str(compose.ROOT), "SEAMARK_WORKERS": "1"}
        command = [sys.executable, *COMMAND, "-c", "1", *OPTIONS]
        for number in range(PLACES):
            machine = (HERE, ELSEWHERE)[number % 2]
            name = f"worker-{'ab'[number % 2]}{number // 2}"
            self._session.start("worker", machine, name=name, command=command, environment=inside)
        wait_until(
            lambda: len(self.app.control.ping(timeout=PING_S, limit=PLACES)) == PLACES, START_S
        )
        self.app.send_task(NOTHING)
        wait_until(self.is_idle, START_S)

    def is_idle(self) -> bool:
        """Return whether no ticket and no task waits or is worked on."""
        return not self.redis.exists(*broker.ticket_keys(self.app), "unacked")

    def nothing_s(self, tasks: int) -> float:
        """Return how long tasks that do nothing take [s]."""
        return timed(lambda: [self.app.send_task(NOTHING) for _ in range(tasks)], self.is_idle)

    def runs_s(self, runs: int) -> float:
        """Return how long runs take that were queued before [s]."""
        submit_runs(self.database, self.settings, runs)
        return timed(
            lambda: broker.send_tickets(self.app, runs), lambda: not count(self.database, *LIVE)
        )

    def claims_s(self) -> list[float]:
        """Return how long each claim took [s]."""
        return [float(value) for value in self.redis.lrange(CLAIMS, 0, -1)]

    def check(self, runs: int) -> None:
        """Say whether each run was evaluated exactly once, and by which machines."""
        with self.database.reading() as session:
            attempts = session.execute(select(Run.attempt, func.count()).group_by(Run.attempt))
            counts = {attempt: number for attempt, number in attempts}
            results = session.scalar(select(func.count()).select_from(Result)) or 0
            by_worker = session.execute(select(Run.worker, func.count()).group_by(Run.worker))
            machines = Counter[str]()
            for worker, number in by_worker:
                machines[(worker or "").partition("@")[2].partition("/")[0]] += number
        claims, ended = len(self.claims_s()), count(self.database, RunState.SUCCEEDED)
        once = (counts, results, claims, ended) == ({1: runs}, runs, runs, runs)
        shares = ", ".join(f"{name} {number}" for name, number in sorted(machines.items()))
        saw = self._session.saw
        saw(f"{ended} of {runs} runs succeeded, {claims} claims, {results} results", once)
        saw(f"{len(machines)} workers had runs: {shares}", len(machines) == PLACES)


def main(arguments: Sequence[str]) -> int:
    """Measure and print; return the exit code."""
    runs = int(*arguments) if arguments else RUNS
    with ExitStack() as held:
        session = held.enter_context(machine_session.started(STEPS))
        fleet = Fleet(session, held)
        fleet.start()
        nothing_s, runs_s = fleet.nothing_s(runs), fleet.runs_s(runs)
        fleet.check(runs)
        percentiles = statistics.quantiles(fleet.claims_s(), n=100)
        wrong = bool(session.wrong)
    what, baseline = f"{runs} runs without simulation", "Celery tasks that do nothing"
    rows = [
        Row(
            what=what,
            value=runs / runs_s,
            unit="runs/s",
            baseline=baseline,
            baseline_value=runs / nothing_s,
        ),
        *(
            Row(what=f"claim with its commit, {name}", value=percentiles[at] * 1e3, unit="ms")
            for name, at in (("median", 49), ("p99", 98))
        ),
    ]
    print(text(rows))
    return int(wrong)
