"""Many runs that simulate nothing, through the real queue; the baseline are empty Celery tasks.

`./run performance fake_runs [RUNS]`. One worker with as many processes as eight workers with
one place each; the runs belong to a hundred users.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from sqlalchemy import func, select

from performance.tables import Row, text
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.database.tables import Run, Worker
from seamark.server.messaging import broker, workers
from seamark.server.runs.record.states import LIVE, RunState
from seamark.server.runs.submission import submission
from seamark.server.runs.submission.submission import Submission
from seamark.server.settings import Settings
from tests.services import valkey

RUNS, USERS, PLACES = 10_000, 100, 8
POLL_S = 0.1
NOTHING = "performance.nothing"  # the task of `fake_worker` that does nothing
CLAIMS = "performance.claims"  # key of a list with the duration of each claim [s]
QUOTAS = {"quota_live": 10**6, "quota_day": 10**6, "quota_bytes": 10**15}
COMMAND = ("-m", "celery", "-A", "performance.service.queue.fake_worker", "worker")
OPTIONS = ("--without-gossip", "--without-mingle", "--loglevel", "ERROR")


def rows(runs: int = RUNS) -> list[Row]:
    """Measure and return the row."""
    with tempfile.TemporaryDirectory() as folder, valkey.on_socket() as broker_url:
        values = {"data": Path(folder), "broker_url": broker_url, "workers": PLACES}
        settings = Settings.model_validate(values | QUOTAS)
        upgrade(settings)
        with (
            closing(Database(settings.database_url)) as database,
            closing(broker.celery_app(settings)) as app,
            closing(broker.connect(settings)) as redis,
        ):
            keys = [*broker.ticket_keys(app), "unacked"]
            worker = fake_worker(settings)
            try:
                app.send_task(NOTHING)
                wait(lambda: not redis.exists(*keys))  # until the worker is ready
                nothing_s = timed(
                    lambda: [app.send_task(NOTHING) for _ in range(runs)],
                    lambda: not redis.exists(*keys),
                )
                # Only now: a worker that starts sends the tickets that queued runs lack.
                submit_runs(database, settings, runs)
                queue_s = timed(
                    lambda: broker.send_tickets(app, runs), lambda: not count(database, *LIVE)
                )
            finally:
                worker.terminate()
                worker.wait()
            if count(database, RunState.SUCCEEDED) != runs:
                raise RuntimeError("some of the runs did not succeed")
    return [
        Row(
            what=f"{runs} runs without simulation, {PLACES} places",
            value=queue_s / runs * 1e3,
            unit="ms wall/run",
            baseline="Celery task that does nothing",
            baseline_value=nothing_s / runs * 1e3,
        )
    ]


def submit_runs(database: Database, settings: Settings, runs: int) -> None:
    """Queue the runs, in turns, for places that are alive as long as it takes."""
    with database.writing() as session:
        place = Worker(name="fake", slots=PLACES, level="none", languages=[], findings=[])
        workers.register(session, place)
        users = [accounts.sign_up(session, f"user{number}", None) for number in range(USERS)]
        valid = [
            submission.validate(
                Submission(
                    viewer=Viewer(user_id=user.id, name=user.name),
                    benchmark="currents-v1",
                    config={},
                    controller="pi",
                ),
                settings,
            )
            for user in users
        ]
        for number in range(runs):
            submission.submit(session, valid[number % USERS], settings)


def fake_worker(settings: Settings) -> "subprocess.Popen[bytes]":
    """Start a worker whose runs simulate nothing."""
    command = [sys.executable, *COMMAND, "-c", str(PLACES), *OPTIONS]
    return subprocess.Popen(command, env=os.environ | settings.environment())


def count(database: Database, *states: RunState) -> int:
    """Return how many runs are in some states."""
    query = select(func.count()).where(Run.state.in_(states))
    with database.reading() as session:
        return session.scalar(query) or 0


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
