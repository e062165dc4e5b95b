"""Many runs that simulate nothing, through the real queue; the baseline are empty Celery tasks.

`./run performance fake_runs [RUNS]`. One worker with as many processes as eight workers with one
slot each; the runs belong to a hundred users.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

from celery import Celery
from redis import Redis
from sqlalchemy import func, select

from performance.tables import Row, text
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.database.tables import Run, Worker
from seamark.server.messaging import broker, workers
from seamark.server.runs.record.states import LIVE, RunState
from seamark.server.runs.submission import submission, validation
from seamark.server.runs.submission.validation import Submission
from seamark.server.settings import Settings
from tests.services import valkey

RUNS, USERS, SLOTS = 10_000, 100, 8
POLL_S = 0.1
NOTHING = "performance.nothing"  # the task of `fake_worker` that does nothing
RUN_S = "FAKE_RUN_S"  # environment variable of `fake_worker`: how long a run takes [s]
CLAIMS = "performance.claims"  # key of a list with the duration of each claim [s]
UNLIMITED = {"quota_live": 10**6, "quota_day": 10**6, "quota_bytes": 10**15}
COMMAND = ("-m", "celery", "-A", "performance.service.queue.fake_worker", "worker")
OPTIONS = ("--without-gossip", "--without-mingle", "--loglevel", "ERROR")


class FakeQueue:
    """The real queue of runs that simulate nothing, seen from outside its workers."""

    def __init__(self, settings: Settings, held: ExitStack) -> None:
        self.settings = settings
        self.database = held.enter_context(closing(Database(settings.database_url)))
        self.app: Celery = held.enter_context(closing(broker.celery_app(settings)))
        self.redis: Redis = held.enter_context(closing(broker.connect(settings)))
        self._viewers: list[Viewer] = []

    def is_idle(self) -> bool:
        """Return whether no ticket and no task waits or is worked on."""
        return not self.redis.exists(*broker.ticket_keys(self.app), "unacked")

    def await_worker(self) -> None:
        """Wait until a worker answers."""
        self.app.send_task(NOTHING)
        wait(self.is_idle)

    def nothing_s(self, tasks: int) -> float:
        """Return how long tasks that do nothing take [s]."""
        return timed(lambda: [self.app.send_task(NOTHING) for _ in range(tasks)], self.is_idle)

    def sign_up(self) -> None:
        """Create the users, and slots that are alive as long as it takes."""
        slots = Worker(name="fake", slots=SLOTS, level="none", languages=[], findings=[])
        with self.database.writing() as session:
            workers.register(session, slots)
            users = [accounts.sign_up(session, f"user{number}", None) for number in range(USERS)]
            self._viewers = [Viewer(user_id=user.id, name=user.name) for user in users]

    def submit(self, runs: int, benchmark: str = "currents-v1") -> None:
        """Submit runs of the users in turn as the web process does, but without tickets.

        Only after `await_worker`: a worker that starts sends the tickets that queued runs lack.
        """
        for number in range(runs):
            viewer = self._viewers[number % USERS]
            wanted = Submission(viewer=viewer, benchmark=benchmark, config={}, controller="pi")
            valid = validation.validate(wanted, self.settings)
            with self.database.writing() as session:
                submission.submit(session, valid, self.settings)

    def runs_s(self, runs: int) -> float:
        """Return how long the submitted runs take from their tickets on [s]."""
        return timed(lambda: broker.send_tickets(self.app, runs), lambda: not self.count(*LIVE))

    def count(self, *states: RunState) -> int:
        """Return how many runs are in some states."""
        query = select(func.count()).where(Run.state.in_(states))
        with self.database.reading() as session:
            return session.scalar(query) or 0


def rows(runs: int = RUNS) -> list[Row]:
    """Measure and return the row."""
    with ExitStack() as held:
        folder = Path(held.enter_context(tempfile.TemporaryDirectory()))
        broker_url = held.enter_context(valkey.on_socket())
        values = {"data": folder, "broker_url": broker_url, "workers": SLOTS}
        settings = Settings.model_validate(values | UNLIMITED)
        upgrade(settings)
        queue = FakeQueue(settings, held)
        with fake_worker(settings):
            queue.await_worker()
            nothing_s = queue.nothing_s(runs)
            queue.sign_up()
            queue.submit(runs)
            queue_s = queue.runs_s(runs)
        if queue.count(RunState.SUCCEEDED) != runs:
            raise RuntimeError("some of the runs did not succeed")
    return [
        Row(
            what=f"{runs} runs without simulation, {SLOTS} slots",
            value=queue_s / runs * 1e3,
            unit="ms wall/run",
            baseline="Celery task that does nothing",
            baseline_value=nothing_s / runs * 1e3,
        )
    ]


@contextmanager
def fake_worker(
    settings: Settings, *, slots: int = SLOTS, run_s: float = 0.0
) -> "Iterator[subprocess.Popen[bytes]]":
    """Run a worker whose runs simulate nothing, and take so long [s]."""
    command = [sys.executable, *COMMAND, "-c", str(slots), *OPTIONS]
    environ = os.environ | settings.environment() | {RUN_S: str(run_s)}
    with subprocess.Popen(command, env=environ) as worker:
        try:
            yield worker
        finally:
            worker.terminate()


def timed(begin: Callable[[], object], ended: Callable[[], bool]) -> float:
    """Return the wall time [s] from the begin until the end."""
    start = time.perf_counter()
    begin()
    wait(ended)
    return time.perf_counter() - start


def wait(ended: Callable[[], bool]) -> None:
    """Wait until something has happened."""
    while not ended():
        time.sleep(POLL_S)


def main(arguments: Sequence[str]) -> int:
    """Measure with these arguments and print."""
    print(text(rows(*map(int, arguments))))
    return 0
