"""The check processes of each worker: checks need not wait behind long runs.

    python -s -P -m seamark.worker.service.check_loop <parent> <name> <slot>

Each carries out one check at a time, in a simulator of its own.
"""

import sys
import threading
import time
from functools import partial
from pathlib import Path

import structlog
from redis import Redis
from redis.exceptions import RedisError
from sqlalchemy.exc import SQLAlchemyError

from seamark.server.database.engine import DATABASE_AWAY, Database
from seamark.server.messaging import broker
from seamark.server.messaging.shared_meters import SharedMeters
from seamark.server.monitoring import log, meters
from seamark.server.monitoring.outages import Outage
from seamark.server.programs import check_queue
from seamark.server.programs.check_queue import SEEN, CheckClaim
from seamark.server.runs.data.files import StorageFailed
from seamark.server.settings import Settings
from seamark.server.storage import storage
from seamark.worker.evaluation.check_recorder import SEED, CheckRecorder
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.ipc.messages import StreamBroken
from seamark.worker.service.run_upload import ProgramGone, program_file
from seamark.worker.service.watched import watched
from seamark.worker.service.worker_process import ShuttingDown, follow_worker
from seamark.worker.zygote.client import BoxBroken, Simulator, SimulatorBroken

POLL_S = 2.0  # [s] between two polls of the queue without a wake-up
WARM_POLL_S = 0.2  # [s] between two checks of whether the worker shuts down
TIMEOUT_S = 120.0  # [s] the limits of a box end every program before this
_log = structlog.get_logger()


class LeaseLost(Exception):
    """Another worker has the check: stop, and write nothing."""


class CheckLoop:
    """Carries out checks, one after the other."""

    def __init__(
        self,
        settings: Settings,
        simulator: Simulator,
        languages: tuple[str, ...],
        stopping: threading.Event,
        *,
        name: str,
    ) -> None:
        self._name = name
        self._settings = settings
        self._simulator = simulator
        self._languages = languages
        self._stopping = stopping
        self._database = Database(settings.database_url)
        self._redis: Redis = broker.connect(settings)
        self._meters = SharedMeters(self._redis)
        self._outage = Outage("database", worker=name)
        self._recovered = False
        self._renew_at = 0.0  # monotonic

    def serve(self) -> None:
        """Carry out checks until the worker shuts down."""
        while not self._stopping.is_set():
            try:
                self._recover()
                while self._check_next():
                    self._meters.add()
                self._outage.over()
            except DATABASE_AWAY as error:
                self._outage.failed(error)
            except SQLAlchemyError:
                _log.exception("checks_failed")
            self._wait()
        self._simulator.stop()

    def _recover(self) -> None:
        """Release the check that the predecessor of this process was carrying out when it died."""
        if not self._recovered:
            with self._database.writing() as session:
                check_queue.recover_from(session, self._name)
            self._recovered = True

    def _wait(self) -> None:
        """Wait for a wake-up, or for a while."""
        try:
            self._redis.blpop([check_queue.WAKE_UP_KEY], timeout=POLL_S)
        except RedisError:
            self._stopping.wait(POLL_S)

    def _check_next(self) -> bool:
        """Carry out one check; False if there is none."""
        with self._database.reading() as session:
            waiting = check_queue.waiting(session, languages=self._languages)
        if not waiting or not self._wait_warm() or storage.worker_refusal(self._settings):
            return False
        with self._database.writing() as session:
            claim = check_queue.claim(
                session,
                self._name,
                languages=self._languages,
                lease_s=self._settings.lease_s,
            )
        if claim is None:
            return False
        try:
            with meters.CHECK_SECONDS.time():
                report = self._report(claim)
        except (SimulatorBroken, StreamBroken, StorageFailed, ProgramGone) as broken:
            _log.error("check_broken", check=claim.check_id, why=str(broken))
            meters.CHECKS_ENDED.labels("broken").inc()
            meters.BOX_FAILURES.inc(isinstance(broken, BoxBroken))
            # That the storage is away or full is not the fault of the check.
            away = isinstance(broken, StorageFailed) or storage.worker_refusal(self._settings)
            self._release(
                claim, attempts_max=check_queue.CLAIMS_MAX if away else check_queue.ATTEMPTS_MAX
            )
            return not away
        except ShuttingDown:
            self._release(claim, attempts_max=check_queue.CLAIMS_MAX)
            return False
        except LeaseLost:
            _log.warning("check_lost", check=claim.check_id)
            return True
        with self._database.writing() as session:
            stored = check_queue.finish(session, claim, report)
        meters.CHECKS_ENDED.labels("passed" if report["ok"] else "failed").inc()
        _log.info("check_ended", check=claim.check_id, ok=report["ok"], stored=stored)
        return True

    def _release(self, claim: CheckClaim, *, attempts_max: int) -> None:
        with self._database.writing() as session:
            check_queue.release(session, claim.check_id, claim.attempt, attempts_max=attempts_max)

    def _report(self, claim: CheckClaim) -> dict[str, object]:
        recorder, deadline = CheckRecorder(), time.monotonic() + TIMEOUT_S
        self._renew_at = time.monotonic() + self._settings.heartbeat_s

        def watch() -> None:
            self._watch(claim, deadline)

        def uploaded(sha256: str) -> Path:
            return watched(partial(program_file, self._settings, sha256), watch)

        job = Job(
            benchmark=claim.benchmark,
            config=claim.config,
            seeds=(SEED,),
            controller="upload",
            program=uploaded(claim.program_sha256),
            filename=claim.program_name,
            language=claim.language,
            vehicle=None if claim.vehicle_sha256 is None else uploaded(claim.vehicle_sha256),
            check=True,
        )
        with self._simulator.begin(job) as simulation:
            outcome = simulation.run(recorder, watch)
        return recorder.report(job, outcome) | {SEEN: recorder.seen()}

    def _wait_warm(self) -> bool:
        """Wait until the simulator is warm: before that, other workers should have the check."""
        try:
            while not self._stopping.is_set():
                if self._simulator.wait_warm(WARM_POLL_S):
                    return True
        except SimulatorBroken as broken:
            _log.error("check_simulator_broken", why=str(broken))
        return False

    def _watch(self, claim: CheckClaim, deadline: float) -> None:
        """Renew the lease; raise if the worker shuts down or the check takes too long."""
        if self._stopping.is_set():
            raise ShuttingDown("the worker shuts down")
        if time.monotonic() >= self._renew_at:
            self._renew_at = time.monotonic() + self._settings.heartbeat_s
            with self._database.writing() as session:
                if not check_queue.renew(session, claim):
                    raise LeaseLost
        if time.monotonic() > deadline:
            self._simulator.stop()
            raise SimulatorBroken(f"a check took more than {TIMEOUT_S:g} s")


def main(parent: str, name: str, slot_json: str) -> None:
    """Be one of the check processes of a worker."""
    stopping = follow_worker(int(parent))
    settings = Settings.load()
    log.configure(settings.log_level)
    slot = WorkerSlot.from_json(slot_json)
    simulator = Simulator(slot, settings.data / "compiled")
    CheckLoop(settings, simulator, slot.languages, stopping, name=name).serve()


if __name__ == "__main__":
    main(*sys.argv[1:])
