"""The slots of a worker for programs that are connected from elsewhere, beside those of its runs.

    python -s -P -m seamark.worker.service.bridge_loop <parent> <name> <mother>

A program across the network may be slow. It holds a slot of its own kind, which no other run could
have, for a limited time (seamark.worker.evaluation.bridged).
"""

import sys
import tempfile
import threading
import time
from dataclasses import replace
from pathlib import Path

import structlog
from redis import Redis
from redis.exceptions import RedisError
from sqlalchemy.exc import SQLAlchemyError

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.server.database import data_folder
from seamark.server.database.engine import Database
from seamark.server.messaging import bridge_sessions, broker, workers
from seamark.server.messaging.bridge_sessions import Keys
from seamark.server.messaging.shared_meters import SharedMeters
from seamark.server.monitoring import log
from seamark.server.monitoring.outages import Outage
from seamark.server.runs.queue import lost_attempts
from seamark.server.runs.queue import queue as run_queue
from seamark.server.runs.queue.queue import Claim
from seamark.server.settings import Settings
from seamark.server.storage import storage
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.service.bridge_relay import BridgeRelay
from seamark.worker.service.claimed_run import evaluate_or_release
from seamark.worker.service.run_driver import RunContext
from seamark.worker.service.worker_process import follow_worker
from seamark.worker.zygote.client import Simulator

POLL_S = 2.0  # that a call waits for an offer
START_S = 20.0  # that the run of a session may take to be inserted
_log = structlog.get_logger()


class BridgeLoop:
    """Takes one session after the other."""

    def __init__(
        self, settings: Settings, simulator: Simulator, stopping: threading.Event, *, name: str
    ) -> None:
        self._settings, self._name = settings, name
        self._stopping = stopping
        self._database = Database(settings.database_url)
        self._redis: Redis = broker.connect(settings)
        self._meters = SharedMeters(self._redis)
        self._context = RunContext(
            settings=settings,
            database=self._database,
            redis=self._redis,
            simulator=simulator,
            isolation=IsolationLevel.NONE,
            shutting_down=stopping.is_set,
        )
        self._outage = Outage("sessions", worker=name)
        self._recovered = False

    def serve(self) -> None:
        """Take sessions until the worker shuts down."""
        while not self._stopping.is_set():
            try:
                self._recover()
                program = self._next_session()
                if program is not None:
                    self._carry_out(program)
                    self._meters.add()
                self._outage.over()
            except (RedisError, SQLAlchemyError) as error:
                self._outage.failed(error)
                self._stopping.wait(POLL_S)
        self._context.simulator.stop()

    def _recover(self) -> None:
        """Fail the run that the predecessor of this process had when it died."""
        if not self._recovered:
            with self._database.writing() as session:
                lost_attempts.recover_from(session, self._name, self._settings)
            self._recovered = True

    def _next_session(self) -> str | None:
        with self._database.reading() as session:
            idle = workers.is_drained(session, self._name)
            idle = idle or not data_folder.computes_alike(session)
        if idle or storage.refusal(self._settings):
            self._stopping.wait(POLL_S)
            return None
        return bridge_sessions.take_offer(self._redis, POLL_S)

    def _carry_out(self, program: str) -> None:
        """Evaluate the run of a session with the program that is connected."""
        bridge_sessions.accept(self._redis, program, self._name)
        claim = self._claim(program)
        if claim is None:
            return
        with tempfile.TemporaryDirectory(prefix="seamark-bridge-") as folder:
            socket = Path(folder, "socket")
            relay = BridgeRelay(self._redis, program, socket)
            relay.start()
            try:
                evaluate_or_release(replace(self._context, bridge=socket), claim)
            finally:
                relay.stop()

    def _claim(self, program: str) -> Claim | None:
        """Return the run that the web process has started here; None if it may not have one."""
        until = time.monotonic() + START_S
        while time.monotonic() < until and not self._stopping.is_set():
            for item in bridge_sessions.read(self._redis, Keys(program).up, at_most=1):
                run_id = bridge_sessions.value_of(item)
                if not isinstance(run_id, int):
                    return None
                with self._database.reading() as session:
                    return run_queue.started(session, run_id, self._name, self._settings)
        return None


def main(parent: str, name: str, mother: str) -> None:
    """Be one of the slots of a worker for connected programs."""
    stopping = follow_worker(int(parent))
    settings = Settings.load()
    log.configure(settings.log_level)
    slot = WorkerSlot(IsolationLevel.NONE, None, mother=int(mother))
    simulator = Simulator(slot, settings.data / "compiled")
    BridgeLoop(settings, simulator, stopping, name=name).serve()


if __name__ == "__main__":
    main(*sys.argv[1:])
