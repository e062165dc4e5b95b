"""One celery child: its connections, its simulator, its core."""

import os
import time

import structlog
from celery import Celery

from seamark.server.database.engine import Database
from seamark.server.messaging import broker
from seamark.server.runs import door as runs
from seamark.server.settings import Settings
from seamark.worker.service.host import Host
from seamark.worker.service.run_driver import StopFlag, Tools, evaluate
from seamark.worker.zygote.client import Simulator, SimulatorBroken

PAUSE_DOUBLINGS = 6  # at most 64 s with the usual settings
LOOK_S = 0.2  # [s] between two looks at the stop flag
_log = structlog.get_logger()


class Member:
    """What one process of the pool works with."""

    def __init__(
        self,
        app: Celery,
        settings: Settings,
        host: Host,
        *,
        index: int,
        stopping: StopFlag,
        simulator: Simulator | None = None,
    ) -> None:
        self.pid = os.getpid()
        self._app = app
        self._settings = settings
        self._host = host
        self._database = Database(settings.database_url)
        self._redis = broker.connect(settings)
        self._simulator = simulator or Simulator(host.place(index), settings.data / "compiled")
        self._simulator.start()
        self._stopping = stopping
        self._broken = 0  # evaluations in a row that failed by our fault
        self._name = f"{host.name}/{index}"

    def work(self) -> None:
        """Claim and evaluate one run, then make sure that the next one has a ticket."""
        if not self._ready():
            return
        with self._database.writing() as session:
            claim = runs.claim(
                session, self._name, languages=self._host.languages, settings=self._settings
            )
        if claim is None:
            return
        sound = evaluate(self._tools(), claim)
        self._broken = 0 if sound else self._broken + 1
        self._recover()
        with self._database.reading() as session:
            waiting = runs.waiting(session)
        if waiting and not self._stopping.is_set():
            broker.ring(self._app)

    def _ready(self) -> bool:
        """Wait until the simulator is warm: before that, other workers should have the runs."""
        try:
            while not self._stopping.is_set():
                if self._simulator.wait_warm(LOOK_S):
                    return True
        except SimulatorBroken as broken:
            _log.error("simulator_broken", why=str(broken), worker=self._name)
            self._broken += 1
            self._recover()
        return False

    def _recover(self) -> None:
        """After failures of ours, leave the next runs to other workers for a while."""
        pause_s = self._settings.sweep_s / 10 * 2 ** min(self._broken, PAUSE_DOUBLINGS)
        until = time.monotonic() + (pause_s if self._broken else 0.0)
        while time.monotonic() < until and not self._stopping.is_set():
            time.sleep(0.1)

    def close(self) -> None:
        """End the simulator and close the connections."""
        self._simulator.stop()
        self._redis.close()
        self._database.close()

    def _tools(self) -> Tools:
        return Tools(
            settings=self._settings,
            database=self._database,
            redis=self._redis,
            simulator=self._simulator,
            isolation=self._host.isolation,
            stopping=self._stopping,
        )
