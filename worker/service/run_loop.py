"""One Celery child: its connections, its simulator, its slot."""

import os
import time
from collections.abc import Callable

import structlog
from celery import Celery

from seamark.server.database import data_folder
from seamark.server.database.engine import DATABASE_AWAY, Database
from seamark.server.messaging import broker, workers
from seamark.server.messaging.shared_meters import SharedMeters
from seamark.server.monitoring.outages import Outage
from seamark.server.runs.queue import lost_attempts
from seamark.server.runs.queue import queue as run_queue
from seamark.server.runs.queue.queue import Claim
from seamark.server.settings import Settings
from seamark.server.storage import storage
from seamark.worker.service.claimed_run import evaluate_or_release
from seamark.worker.service.host import Host
from seamark.worker.service.live_states import announce
from seamark.worker.service.run_driver import RunContext
from seamark.worker.zygote.client import Simulator, SimulatorBroken

PAUSE_DOUBLINGS = 6  # at most 64 s with the usual settings
OUTDATED = "the service was upgraded; this worker would compute other results: restart it"
PASS_ON_S = 0.5  # [s] for which a drained worker keeps a ticket
AWAY_S = 1.0  # [s] for which a process rests when the database was away
WARM_POLL_S = 0.2  # [s] between two checks of whether the worker shuts down
WARM_MAX_S = 600.0  # [s] for which a process that starts keeps a ticket; the others send more
_log = structlog.get_logger()


class RunLoop:
    """Evaluates one run per ticket."""

    def __init__(
        self,
        app: Celery,
        settings: Settings,
        host: Host,
        *,
        index: int,
        shutting_down: Callable[[], bool],
        simulator: Simulator | None = None,
    ) -> None:
        self.pid = os.getpid()
        self._app = app
        self._settings = settings
        self._host = host
        self._database = Database(settings.database_url)
        self._redis = broker.connect(settings)
        self._meters = SharedMeters(self._redis)
        self._simulator = simulator or Simulator(host.slot(index), settings.data / "compiled")
        self._simulator.start()
        self._shutting_down = shutting_down
        self._failures = 0  # of the platform, in a row
        self._name = f"{host.name}/{index}"
        self._outage = Outage("database", worker=self._name)
        self._recover()

    def run_next(self) -> None:
        """Claim and evaluate one run, then make sure that the next one has a ticket.

        Without the database the ticket is lost; recovery sends it again.
        """
        try:
            self._run_next()
            self._outage.over()
        except DATABASE_AWAY as error:
            self._outage.failed(error)
            self._wait(AWAY_S)

    def _run_next(self) -> None:
        if not self._wait_warm():
            return
        if why := storage.worker_refusal(self._settings):  # recovery sends tickets again
            _log.error("no_claim", worker=self._name, why=why)
            return
        claim = self.claim()
        if claim is None:
            self._pass_on()
            return
        succeeded = evaluate_or_release(self._context(), claim)
        self._meters.add()
        self._failures = 0 if succeeded else self._failures + 1
        self._pause()
        with self._database.reading() as session:
            waiting = run_queue.length(session)
        if waiting:  # also when this worker shuts down: another one takes its run over
            broker.send_tickets(self._app)

    def claim(self) -> Claim | None:
        """Claim the next run; None without one for this worker."""
        return run_queue.claim(
            self._database, self._name, languages=self._host.languages, settings=self._settings
        )

    def _pass_on(self) -> None:
        """Leave the ticket of a drained worker to another one, if there is any that claims runs."""
        with self._database.reading() as session:
            claims_none = not data_folder.computes_alike(session)
            if claims_none:
                _log.error("no_claim", worker=self._name, why=OUTDATED)
            claims_none |= workers.is_drained(session, self._name)
            others = claims_none and workers.slot_count(session) and run_queue.length(session)
        if others:
            self._wait(PASS_ON_S)  # the ticket may come back here
            broker.send_tickets(self._app)

    def _recover(self) -> None:
        """Queue the run that the predecessor of this process was evaluating when it died."""
        try:
            with self._database.writing() as session:
                recovery = lost_attempts.recover_from(session, self._name, self._settings)
        except DATABASE_AWAY as error:  # its lease will end
            self._outage.failed(error)
            return
        announce(self._app, self._redis, recovery)

    def _wait_warm(self) -> bool:
        """Return whether the simulator is warm, after waiting for it; pass the ticket on before.

        Another process of the pool may be ready. This one returns late, so that Celery gives it no
        other ticket: each would count as a task, and after some a process is replaced, with a
        simulator that is still being compiled.
        """
        until = time.monotonic() + WARM_MAX_S
        try:
            if self._simulator.wait_warm(0.0):
                return True
            broker.send_tickets(self._app)
            while time.monotonic() < until and not self._shutting_down():
                if self._simulator.wait_warm(WARM_POLL_S):
                    return True
        except SimulatorBroken as broken:
            _log.error("simulator_broken", why=str(broken), worker=self._name)
            self._failures += 1
            self._pause()
        return False

    def _pause(self) -> None:
        """After failures of the platform, leave the next runs to other workers for a while."""
        pause_s = self._settings.sweep_s / 10 * 2 ** min(self._failures, PAUSE_DOUBLINGS)
        self._wait(pause_s if self._failures else 0.0)

    def _wait(self, seconds: float) -> None:
        """Wait, but not longer than until the worker shuts down."""
        until = time.monotonic() + seconds
        while time.monotonic() < until and not self._shutting_down():
            time.sleep(0.1)

    def close(self) -> None:
        """End the simulator and close the connections."""
        self._simulator.stop()
        self._redis.close()
        self._database.close()

    def _context(self) -> RunContext:
        return RunContext(
            settings=self._settings,
            database=self._database,
            redis=self._redis,
            simulator=self._simulator,
            isolation=self._host.isolation,
            shutting_down=self._shutting_down,
        )
