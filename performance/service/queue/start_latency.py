"""From submitting a run to its start, on an idle service with a real worker, in both deployments.

Embedded is SQLite and a broker on a socket; production is PostgreSQL and a broker over TCP.

Each run is submitted when the one before it has ended. A Celery child is replaced after a thousand
tasks, which this does not reach; with a hundred, some three runs at each replacement waited for 0.4
to 1.4 s.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import numpy as np

from performance.tables import Row
from seamark.programs import preparation
from seamark.sandbox.languages.python import PYTHON
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.messaging import broker
from seamark.server.programs import store
from seamark.server.programs.store import StoredProgram
from seamark.server.runs.showing import views
from seamark.server.runs.showing.views import RunView
from seamark.server.runs.submission import submission, validation
from seamark.server.runs.submission.validation import UPLOAD, Submission
from seamark.server.settings import Settings
from seamark.worker.service.command_line import worker_arguments
from tests.services import postgres, valkey

RUNS = 150  # of each kind
SHORT = {"levels": [0.0], "level_duration_s": 2.0, "settle_s": 1.0}
POLL_S = 0.02
DEADLINE_S = 300.0  # of one run: the first start compiles the simulator


def rows(runs: int = RUNS) -> list[Row]:
    """Measure built-in controllers and uploads on both deployments and return the rows."""
    table: list[Row] = []
    for name in ("embedded", "production"):
        with ExitStack() as stack:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
            values: dict[str, object] = {"data": folder, "quota_day": 10**6}
            if name == "production":
                server = stack.enter_context(postgres.server())
                database = postgres.database(server.folder, "latency")
                values["database_url"] = stack.enter_context(database)
                values["broker_url"] = stack.enter_context(valkey.on_port())
            else:
                values["broker_url"] = stack.enter_context(valkey.on_socket())
            for kind, times in _times(Settings.model_validate(values), runs).items():
                table += _rows(f"{name}, {kind}", times)
    return table


def _times(settings: Settings, runs: int) -> dict[str, list[float]]:
    """Return the times from submitting to running [ms] of each kind of program."""
    upgrade(settings)
    with closing(Database(settings.database_url)) as database, real_worker(settings):
        with database.writing() as session:
            user = accounts.sign_up(session, "ann", None)
            viewer = Viewer(user_id=user.id, name=user.name)
        program = _program(settings)
        measured: dict[str, list[float]] = {"built-in": [], "upload": []}
        evaluate(database, settings, viewer, None)  # until the worker is warm
        evaluate(database, settings, viewer, program)
        for _ in range(runs):
            for kind, uploaded in (("built-in", None), ("upload", program)):
                run = evaluate(database, settings, viewer, uploaded)
                measured[kind].append(1e3 * ((run.started_at or 0.0) - run.queued_at))
    return measured


def _rows(kind: str, times: list[float]) -> Iterator[Row]:
    p50, p99 = np.percentile(times, (50, 99))
    for what, value in (("p50", p50), ("p99", p99), ("maximum", max(times))):
        yield Row(what=f"submit to running, {kind}, {what}", value=float(value), unit="ms")


@contextmanager
def real_worker(settings: Settings) -> Iterator[None]:
    """Run a worker as `seamark worker` does."""
    command = [sys.executable, *worker_arguments(settings)]
    environment = os.environ | settings.environment()
    with subprocess.Popen(command, env=environment) as worker:
        try:
            yield
        finally:
            worker.terminate()


def _program(settings: Settings) -> StoredProgram:
    sample = PYTHON.self_test
    prepared = preparation.prepare(sample.upload(), sample.upload_name, role="controller")
    return store.save(prepared, settings)


def evaluate(
    database: Database, settings: Settings, viewer: Viewer, program: StoredProgram | None
) -> RunView:
    """Submit a run as the web process does and return it when it has ended."""
    wanted = Submission(
        viewer=viewer,
        benchmark="currents-v1",
        config=SHORT,
        controller="pi" if program is None else UPLOAD,
        program=program,
    )
    valid = validation.validate(wanted, settings)
    with closing(broker.celery_app(settings)) as app:
        with database.writing() as session:
            run_id = submission.submit(session, valid, settings)
        broker.send_tickets(app)
    deadline = time.monotonic() + DEADLINE_S
    while time.monotonic() < deadline:
        with database.reading() as session:
            run = views.show(session, run_id)
        if run is not None and run.state.final:
            return run
        time.sleep(POLL_S)
    raise TimeoutError(f"run {run_id} has not ended")
