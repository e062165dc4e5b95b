"""Many runs that simulate nothing, through eight workers on two machines without a shared folder.

`./run machines fake-runs [RUNS]`. Each worker is a container of compose.yaml or compose.worker.yaml
with its settings, rights and secrets; PostgreSQL, Valkey and the S3 server are on the first
machine. The baseline are Celery tasks that do nothing, through the same workers.
"""

import statistics
import sys
from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack

from sqlalchemy import func, select

from performance.service.queue.fake_runs import (
    CLAIMS,
    COMMAND,
    OPTIONS,
    RUNS,
    SLOTS,
    UNLIMITED,
    FakeQueue,
)
from performance.tables import Row, text
from seamark.server.database.tables import Result, Run
from seamark.server.runs.record.states import RunState
from seamark.server.settings import Settings
from tests.chaos import machine_session
from tests.chaos.machine_session import ELSEWHERE, HERE, START_S, STORES, Session
from tests.services import compose
from tests.worker.conftest import wait_until

PING_S = 5.0
SECRETS = ("storage_access_key", "storage_secret_key", "seed_key")
STEPS = ("migrate", "worker-rights")


class Fleet(FakeQueue):
    """The workers, and what they share."""

    def __init__(self, session: Session, held: ExitStack) -> None:
        self._session = session
        secrets = session.host.secrets
        values = {
            "data": session.host.folder / "measuring",
            "database_url": session.url("database_url"),
            "broker_url": session.url("broker_url"),
            "storage_url": "s3://seamark",
            "storage_endpoint": f"http://{STORES['objects']}:3900",
            **{name: (secrets / name).read_text() for name in SECRETS},
        }
        super().__init__(Settings.model_validate(values | UNLIMITED), held)

    def start(self) -> None:
        """Start the workers, half of them on each machine, and wait for all."""
        inside = {"PYTHONPATH": str(compose.ROOT), "SEAMARK_WORKERS": "1"}
        command = [sys.executable, *COMMAND, "-c", "1", *OPTIONS]
        for number in range(SLOTS):
            machine = (HERE, ELSEWHERE)[number % 2]
            name = f"worker-{'ab'[number % 2]}{number // 2}"
            self._session.start("worker", machine, name=name, command=command, environment=inside)
        wait_until(
            lambda: len(self.app.control.ping(timeout=PING_S, limit=SLOTS)) == SLOTS, START_S
        )
        self.await_worker()

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
        claims, ended = len(self.claims_s()), self.count(RunState.SUCCEEDED)
        once = (counts, results, claims, ended) == ({1: runs}, runs, runs, runs)
        shares = ", ".join(f"{name} {number}" for name, number in sorted(machines.items()))
        saw = self._session.saw
        saw(f"{ended} of {runs} runs succeeded, {claims} claims, {results} results", once)
        saw(f"{len(machines)} workers had runs: {shares}", len(machines) == SLOTS)


def main(arguments: Sequence[str]) -> int:
    """Measure and print; return the exit code."""
    runs = int(*arguments) if arguments else RUNS
    with ExitStack() as held:
        session = held.enter_context(machine_session.started(STEPS))
        fleet = Fleet(session, held)
        fleet.start()
        nothing_s = fleet.nothing_s(runs)
        fleet.sign_up()
        fleet.submit(runs)
        runs_s = fleet.runs_s(runs)
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
