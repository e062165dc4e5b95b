"""A real service without its web process: broker, database, worker with simulator and boxes."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from redis import Redis

from seamark.sandbox.isolation.proc_stats import parent_of, tree
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.messaging import broker
from seamark.server.programs import check_queue
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings
from seamark.worker.service.command_line import ONE_THREAD, worker_arguments
from tests.cast import Backend
from tests.services import forked_workers, tables
from tests.services.forked_workers import ForkedWorker
from tests.worker.processes import command_line

SHORT = {"levels": [0.0, 0.2], "level_duration_s": 4.0, "settle_s": 1.0}
LONG = {"levels": [0.0, 0.2], "level_duration_s": 600.0, "settle_s": 1.0}
# The built-in controller `p`, without its limit of the velocity reference.
P = """
class Controller:
    def __init__(self, config):
        self.kp = config["kp"]
    def reset(self, level):
        pass
    def step(self, observation):
        return [self.kp * observation.error[0], self.kp * observation.error[1], 0.0, 0.0]
"""
START_S = 240.0  # the first start of all compiles the simulator, on a busy machine for minutes
# No box waits: three processes would start one for each runtime, which few tests need.
QUICK = {"lease_s": 3.0, "workers": 1, "warm_boxes": 0}
WorkerProcess = ForkedWorker | subprocess.Popen[bytes]
POLL_S = 0.1  # each look at a run or at all processes takes CPU from what it waits for


def wait_until(happened: Callable[[], object], seconds: float = START_S) -> None:
    """Wait until something has happened."""
    deadline = time.monotonic() + seconds
    while not happened():
        assert time.monotonic() < deadline, "it did not happen"
        time.sleep(POLL_S)


@dataclass
class Service(Backend):
    """The cast's database with a broker and workers, and what the tests do to them."""

    redis: Redis
    workers: list[WorkerProcess] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.app = broker.celery_app(self.settings)

    def start_worker(self) -> WorkerProcess:
        """Start a worker, as a fork that has loaded its modules."""
        self.workers.append(forked_workers.start(*self._worker()))
        return self.workers[-1]

    def start_worker_anew(self) -> WorkerProcess:
        """Start a worker as the service does."""
        arguments, environment = self._worker()
        command = [sys.executable, *arguments]
        self.workers.append(subprocess.Popen(command, env=environment, start_new_session=True))
        return self.workers[-1]

    def _worker(self) -> tuple[list[str], dict[str, str]]:
        environment = os.environ | ONE_THREAD | self.settings.environment()
        return worker_arguments(self.settings), environment

    def kill_worker(self) -> None:
        """Kill everything of the last worker at once, as a power cut would."""
        worker = self.workers.pop()
        with suppress(ProcessLookupError):  # a test may have stopped it and seen it end
            os.killpg(worker.pid, signal.SIGKILL)
        worker.wait()

    def pool(self) -> list[int]:
        """Return the processes of the last worker's pool: the children that have its command."""
        worker = self.workers[-1].pid
        pids = [pid for pid in tree(worker) if parent_of(pid) == worker]
        return [pid for pid in pids if command_line(pid) == command_line(worker)]

    def pool_child(self) -> int:
        """Return the process of the last worker's pool, which has one."""
        [child] = self.pool()
        return child

    def submit(self, config: Mapping[str, object] = SHORT, **changes: Any) -> int:
        """Queue a run and tell the workers."""
        run_id = self.queue(config=config, **({"seed": 3} | changes))
        assert broker.send_tickets(self.app)
        return run_id

    def submit_program(
        self, source: str, config: Mapping[str, object] = SHORT, **changes: Any
    ) -> int:
        program = self.store_program(source.encode())
        return self.submit(config, controller="upload", program=program, **changes)

    def check(self, source: bytes, name: str = "mine.py", **config: object) -> dict[str, Any]:
        """Return the report of a check of a program."""
        program, user_id = self.store_program(source, name), self.user_id("ann")
        with self.database.writing() as session:
            check_id = check_queue.enqueue(session, user_id, "currents-v1", dict(config), program)
        check_queue.wake_worker(self.redis)
        return self.report_of(check_id)

    def report_of(self, check_id: int) -> dict[str, Any]:
        """Return the report of a check of ann's when there is one."""
        deadline, user_id = time.monotonic() + START_S, self.user_id("ann")
        while True:
            with self.database.reading() as session:
                view = check_queue.show(session, check_id, user_id)
            assert view is not None
            if view.report is not None:
                return view.report
            assert time.monotonic() < deadline, f"still {view.state}"
            time.sleep(POLL_S)

    def wait(
        self, run_id: int, until: Callable[[RunView], bool], seconds: float = START_S
    ) -> RunView:
        deadline = time.monotonic() + seconds
        while not until(view := self.show(run_id)):
            assert time.monotonic() < deadline, f"still {view.state}, attempt {view.attempt}"
            time.sleep(POLL_S)
        return view

    def ended(self, run_id: int, seconds: float = START_S) -> RunView:
        return self.wait(run_id, lambda view: view.state.final, seconds)

    def settled(self, seconds: float = 30.0) -> bool:
        """Wait until the broker holds no ticket, neither waiting nor delivered."""
        deadline = time.monotonic() + seconds
        while self.redis.exists(*broker.ticket_keys(self.app), "unacked"):
            if time.monotonic() > deadline:
                return False
            time.sleep(POLL_S)
        return True

    def time_to_cancel(self, run_id: int) -> tuple[RunView, float]:
        """Cancel a running run; return it with the seconds until its worker has stopped."""
        started = time.monotonic()
        assert self.cancel(run_id)
        view = self.wait(run_id, lambda view: "t_reached" in view.detail)
        return view, time.monotonic() - started

    def files(self, run_id: int) -> RunFiles:
        return RunFiles(self.settings.data, run_id)

    def close(self) -> None:
        while self.workers:
            self.kill_worker()
        self.redis.close()
        self.database.close()


def service_with(settings: Settings) -> Service:
    upgrade(settings)
    backend = Backend.with_cast(Database(settings.database_url), settings)
    return Service(**vars(backend), redis=broker.connect(settings))


@pytest.fixture(scope="module")
def _bare(tmp_path_factory: pytest.TempPathFactory, _valkey: str) -> Iterator[Service]:
    """A service on SQLite and a Unix socket, without a worker, shared by the tests of a module."""
    data = tmp_path_factory.mktemp("service")
    with Redis.from_url(_valkey) as client:
        client.flushall()
    urls = {"data": data, "broker_url": _valkey}
    quotas = {"quota_live": 100, "quota_day": 1000}
    made = service_with(Settings.model_validate(urls | QUICK | quotas))
    yield made
    made.close()


@pytest.fixture(scope="module")
def running(_bare: Service) -> Service:
    """The same with a worker."""
    _bare.start_worker()
    return _bare


@pytest.fixture
def service(settings: Settings) -> Iterator[Service]:
    """A service on SQLite and a Unix socket, without a worker yet."""
    tables.create(settings).close()
    made = service_with(settings.model_copy(update=QUICK))
    yield made
    made.close()


@pytest.fixture
def production(tmp_path: Path, postgres_url: str, redis_tcp_url: str) -> Iterator[Service]:
    """A service on PostgreSQL and TCP, without a worker yet."""
    urls = {"database_url": postgres_url, "broker_url": redis_tcp_url}
    more = {"data": tmp_path / "data", "secret_key": "test"}
    made = service_with(Settings.model_validate(urls | more | QUICK))
    yield made
    made.close()
