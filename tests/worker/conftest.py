"""A real service without its web process: broker, database, worker with simulator and boxes."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from redis import Redis

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Viewer
from seamark.server.checks import queue
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.messaging import broker
from seamark.server.programs import store
from seamark.server.runs import door as runs
from seamark.server.runs.files import RunFiles
from seamark.server.settings import Settings
from seamark.worker.service.command_line import worker_arguments

SHORT = {"levels": [0.0, 0.2], "level_duration_s": 4.0, "settle_s": 1.0}
LONG = {"levels": [0.0, 0.2], "level_duration_s": 600.0, "settle_s": 1.0}
START_S = 240.0  # the first start of all compiles the simulator, on a busy machine for minutes
QUICK = {"lease_s": 3.0, "heartbeat_s": 1.0, "sweep_s": 1.0, "workers": 1}


@dataclass
class Service:
    """What the tests do to a service."""

    settings: Settings
    database: Database
    redis: Redis
    viewer: Viewer
    workers: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.app = broker.celery_app(self.settings)

    def start_worker(self) -> subprocess.Popen[bytes]:
        command = [sys.executable, *worker_arguments(self.settings)]
        environment = os.environ | self.settings.environment()
        worker = subprocess.Popen(command, env=environment, start_new_session=True)
        self.workers.append(worker)
        return worker

    def kill_worker(self) -> None:
        """Kill everything of the last worker at once, as a power cut would."""
        worker = self.workers.pop()
        os.killpg(worker.pid, signal.SIGKILL)
        worker.wait()

    def queue(self, config: dict[str, object] = SHORT, **wishes: object) -> int:
        order = {"benchmark": "currents-v1", "config": config, "controller": "pi", "seed": 3}
        with self.database.writing() as session:
            order_ = runs.Order(viewer=self.viewer, **(order | wishes))
            run_id = runs.enqueue(session, order_, self.settings)
        assert broker.ring(self.app)
        return run_id

    def upload(self, source: str, config: dict[str, object] = SHORT, **wishes: object) -> int:
        return self.queue(config, controller="upload", program=self.keep(source), **wishes)

    def keep(self, source: str, role: str = "controller") -> store.StoredProgram:
        stream = BytesIO(source.encode())
        data = self.settings.data
        return store.store(stream, "mine.py", limit=10**6, data=data, role=role)

    def check(self, source: bytes, name: str = "mine.py", **config: object) -> dict[str, Any]:
        """Return what a check of a program says."""
        program = store.store(BytesIO(source), name, limit=10**6, data=self.settings.data)
        user_id = self.viewer.user_id
        assert user_id is not None
        with self.database.writing() as session:
            check_id = queue.order(session, user_id, "currents-v1", dict(config), program)
        queue.ring(self.redis)
        deadline = time.monotonic() + START_S
        while True:
            with self.database.reading() as session:
                view = queue.show(session, check_id, user_id)
            assert view is not None
            if view.answer is not None:
                return view.answer
            assert time.monotonic() < deadline, f"still {view.state}"
            time.sleep(0.02)  # the database announces nothing

    def show(self, run_id: int) -> runs.RunView:
        with self.database.reading() as session:
            view = runs.show(session, run_id, self.settings)
        assert view is not None
        return view

    def wait(
        self, run_id: int, until: Callable[[runs.RunView], bool], seconds: float = START_S
    ) -> runs.RunView:
        deadline = time.monotonic() + seconds
        while not until(view := self.show(run_id)):
            assert time.monotonic() < deadline, f"still {view.state}, attempt {view.attempt}"
            time.sleep(0.02)  # the database announces nothing
        return view

    def ended(self, run_id: int, seconds: float = START_S) -> runs.RunView:
        return self.wait(run_id, lambda view: view.state.final, seconds)

    def settled(self, seconds: float = 30.0) -> bool:
        """Wait until the broker holds no ticket, neither waiting nor delivered."""
        deadline = time.monotonic() + seconds
        while self.redis.exists(*broker.ticket_keys(self.app), "unacked"):
            if time.monotonic() > deadline:
                return False
            time.sleep(0.05)
        return True

    def files(self, run_id: int) -> RunFiles:
        return RunFiles(self.settings.data, run_id)

    def close(self) -> None:
        while self.workers:
            self.kill_worker()
        self.redis.close()
        self.database.close()


def service_with(settings: Settings) -> Service:
    upgrade(settings)
    database = Database(settings.database_url)
    with database.writing() as session:
        user = accounts.sign_up(session, "ann", None)
        viewer = Viewer(user_id=user.id, name=user.name)
    return Service(settings, database, broker.connect(settings), viewer)


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory, _valkey: str) -> Iterator[Service]:
    """A service on SQLite and a Unix socket, with a worker, shared by the tests of a module."""
    data = tmp_path_factory.mktemp("service")
    with Redis.from_url(_valkey) as client:
        client.flushall()
    quotas = {"quota_live": 100, "quota_day": 1000}
    made = service_with(Settings(data=data, broker_url=_valkey, **QUICK, **quotas))
    made.start_worker()
    yield made
    made.close()


@pytest.fixture
def service(settings: Settings) -> Iterator[Service]:
    """A service on SQLite and a Unix socket, without a worker yet."""
    made = service_with(settings.model_copy(update=QUICK))
    yield made
    made.close()


@pytest.fixture
def production(tmp_path: Path, postgres_url: str, redis_tcp_url: str) -> Iterator[Service]:
    """A service on PostgreSQL and TCP, without a worker yet."""
    urls = {"database_url": postgres_url, "broker_url": redis_tcp_url}
    made = service_with(Settings(data=tmp_path / "data", secret_key="test", **urls, **QUICK))
    yield made
    made.close()
