"""A whole service on this machine, whose parts a test can kill, stop and start again."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import httpx
from numpy.random import Generator
from redis import Redis
from redis.exceptions import RedisError

from seamark.client.sessions import NO_CERTIFICATES
from seamark.embedded.broker import command as broker_command
from seamark.embedded.broker import find_server
from seamark.sandbox.isolation.proc_stats import parent_of, tree
from seamark.server.settings import Settings
from seamark.worker.service.command_line import ONE_THREAD, worker_arguments
from tests.services import faulty_s3, forked_workers, postgres, s3
from tests.services.faulty_s3 import FaultyS3
from tests.services.ports import free_port
from tests.worker.conftest import Service, WorkerProcess, service_with, wait_until
from tests.worker.processes import command_line

ZYGOTE = "seamark.worker.zygote.process"
CHECK_LOOP = "seamark.worker.service.check_loop"
MAINTENANCE = "seamark.worker.service.maintenance"
RELEASES = ("run_released", "run_not_evaluated", "evaluation_broke", "storage_failed")
COPIES = 2  # of a worker and of a web server
START_S = 240.0
QUOTAS = {"quota_live": 10_000, "quota_day": 100_000, "quota_bytes": 10**12}


class Broker:
    """A Valkey server as `seamark up` starts it; what was sent survives a kill."""

    def __init__(self, folder: Path) -> None:
        self._socket = folder / "broker.sock"
        self._state = folder / "broker"
        self._state.mkdir()
        self._process: subprocess.Popen[bytes] | None = None
        self.url = f"unix://{self._socket}"

    @property
    def pid(self) -> int | None:
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        command = broker_command(find_server(), socket=self._socket, state=self._state)
        self._process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        with Redis.from_url(self.url) as client:
            wait_until(lambda: _answers(client))

    def kill(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None


class Installation:
    """Some workers, as many web servers, a broker and PostgreSQL."""

    def __init__(
        self,
        folder: Path,
        database: postgres.Server,
        url: str,
        *,
        service: Callable[[Settings], Service] = service_with,
        objects: FaultyS3 | None = None,
        copies: int = COPIES,
        forked: bool = False,
        **settings: Any,
    ):
        if forked:
            forked_workers.prepare()
        self.objects = objects
        self._others = set(tree(os.getpid()))  # of other tests in this process, and the database
        self.broker = Broker(folder)
        self.broker.start()
        self.database = database
        urls = {"data": folder / "data", "database_url": url, "broker_url": self.broker.url}
        self.settings = Settings.model_validate(
            urls | QUOTAS | {"workers": 1, "secret_key": "test"} | settings
        )
        self.service = service(self.settings)
        self._forked = forked
        self.log = (folder / "log").open("ab")
        self.ports = [free_port() for _ in range(copies)]
        self.web_servers = [self._web_server(port) for port in self.ports]
        self.workers = [self._worker() for _ in range(copies)]

    def _worker(self) -> WorkerProcess:
        if self._forked:
            environment = os.environ | ONE_THREAD | self.settings.environment()
            return forked_workers.start(worker_arguments(self.settings), environment, self.log)
        return self._start("worker")

    def _web_server(self, port: int) -> "subprocess.Popen[bytes]":
        return self._start("web", "--port", str(port))

    def _start(self, *arguments: str) -> "subprocess.Popen[bytes]":
        command = [sys.executable, "-s", "-P", "-m", "seamark.cli.main", *arguments]
        environment = os.environ | self.settings.environment()
        return subprocess.Popen(
            command, env=environment, stdout=self.log, stderr=self.log, start_new_session=True
        )

    def restart_worker(self, at: int, number: signal.Signals) -> None:
        """End a worker by a signal, and start another one in its place."""
        self.workers[at].send_signal(number)
        self.workers[at].wait()
        self.workers[at] = self._worker()

    def restart_web_server(self, at: int, number: signal.Signals) -> None:
        wait_until(lambda: all(map(_serves, self.ports)))  # one of them always does
        self.web_servers[at].send_signal(number)
        self.web_servers[at].wait()
        self.web_servers[at] = self._web_server(self.ports[at])

    def evaluates(self) -> bool:
        """Return whether all workers have started their simulators."""
        return all(self.processes(worker.pid, ZYGOTE) for worker in self.workers)

    def ready_worker(self, chance: Generator) -> int:
        """Return one of the workers, as soon as all of them can evaluate runs."""
        wait_until(self.evaluates)
        return int(chance.integers(len(self.workers)))

    @staticmethod
    def processes(worker: int, module: str) -> list[int]:
        """Return the processes of a worker that run a module."""
        return [pid for pid in tree(worker) if module.encode() in command_line(pid)]

    def pool_child(self, worker: int) -> int | None:
        """Return a process of a worker's pool: a fork, with the command of the worker."""
        pids = [pid for pid in tree(worker) if parent_of(pid) == worker]
        own = command_line(worker)
        return next((pid for pid in pids if command_line(pid) == own), None)

    def simulator_child(self, worker: int) -> int | None:
        """Return the process that evaluates a run: a fork of the zygote."""
        zygotes = self.processes(worker, ZYGOTE)
        return next((pid for pid in zygotes if parent_of(pid) in zygotes), None)

    def orphans(self) -> list[int]:
        """Return the processes that have lost the part of the service to which they belong."""
        mine = os.getpid()
        parts = {process.pid for process in (*self.workers, *self.web_servers)}
        known = {self.database.pid, self.broker.pid, *parts, *self._others}
        lost = [pid for pid in tree(mine) if parent_of(pid) == mine and pid not in known]
        return [pid for pid in lost if not _reaped(pid)]

    def releases(self) -> list[str]:
        """Return what the logs of the workers say of the attempts that ended without a result."""
        lines = Path(self.log.name).read_text(encoding="utf-8", errors="replace").splitlines()
        return [line for line in lines if any(event in line for event in RELEASES)]

    def stop(self) -> None:
        """Stop all parts as an operator would."""
        for process in (*self.web_servers, *self.workers):
            process.terminate()
        for process in (*self.web_servers, *self.workers):
            process.wait(timeout=60)
        self.service.close()
        self.broker.kill()
        self.log.close()


@contextmanager
def installation(**settings: Any) -> Iterator[Installation]:
    """Yield a running installation in a temporary folder."""
    with TemporaryDirectory(prefix="chaos") as folder, postgres.server() as server:
        with postgres.database(server.folder, "seamark") as url:
            made = Installation(Path(folder), server, url, **settings)
            try:
                wait_until(made.evaluates)
                yield made
            finally:
                made.stop()


@contextmanager
def installation_with_objects() -> Iterator[Installation]:
    """Yield a running installation whose runs and programs are in an object storage."""
    with s3.server() as server, faulty_s3.in_front_of(server.endpoint) as objects:
        stored = server.settings("chaos") | {"storage_endpoint": objects.endpoint}
        with installation(objects=objects, **stored) as made:
            yield made


def _reaped(pid: int) -> bool:
    """Reap a process that has ended; False if it has not."""
    try:
        return os.waitpid(pid, os.WNOHANG)[0] == pid
    except ChildProcessError:
        return True


def _serves(port: int) -> bool:
    try:
        address = f"http://127.0.0.1:{port}/healthz"
        return httpx.get(address, verify=NO_CERTIFICATES).is_success
    except httpx.TransportError:
        return False


def _answers(client: Redis) -> bool:
    try:
        return bool(client.ping())
    except RedisError:
        return False
