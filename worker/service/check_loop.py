"""Beside each worker: carries out checks, so that nobody waits for one behind long runs.

    python -s -P -m seamark.worker.service.check_loop <place> <languages with commas>

One check at a time, in a simulator of its own that is started with the first check.
"""

import os
import signal
import sys
import threading
import time

import numpy as np
import structlog
from redis import Redis
from redis.exceptions import RedisError
from sqlalchemy.exc import SQLAlchemyError

from seamark.server.checks import queue
from seamark.server.checks.queue import CheckClaim
from seamark.server.database.engine import Database
from seamark.server.messaging import broker
from seamark.server.programs import store
from seamark.server.settings import Settings
from seamark.sim.recording.telemetry import WIDTH
from seamark.worker.evaluation.check import Glimpse, answer_of
from seamark.worker.evaluation.job import Job, Place
from seamark.worker.ipc.messages import Frame, StreamBroken
from seamark.worker.ipc.messages import Kind as FrameKind
from seamark.worker.ipc.process_control import die_with_parent
from seamark.worker.service.app import settings
from seamark.worker.zygote.client import Simulator, SimulatorBroken

LOOK_S = 2.0  # [s] between two looks into the table when nobody rings
WAIT_S = 0.2  # [s] for the simulator's next message
MOST_S = 120.0  # [s] the limits of a box end every program before this
_log = structlog.get_logger()


class Stopping(Exception):
    """The worker shuts down."""


class Lane:
    """What carries out checks, one after the other."""

    def __init__(
        self, settings: Settings, simulator: Simulator, languages: tuple[str, ...]
    ) -> None:
        self._settings = settings
        self._simulator = simulator
        self._languages = languages
        self._database = Database(settings.database_url)
        self._redis: Redis = broker.connect(settings)
        self._ended = threading.Event()

    def stop(self) -> None:
        """Let `serve` end soon."""
        self._ended.set()

    def serve(self) -> None:
        """Go round until the worker ends."""
        while not self._ended.is_set():
            try:
                while self._next():
                    pass
            except SQLAlchemyError:
                _log.exception("checks_failed")
            self._wait()
        self._simulator.stop()

    def _wait(self) -> None:
        """Wait for the bell, or for a while."""
        try:
            self._redis.blpop([queue.WAKE_UP_KEY], timeout=LOOK_S)
        except RedisError:
            self._ended.wait(LOOK_S)

    def _next(self) -> bool:
        """Carry out one check; False if there is none."""
        with self._database.reading() as session:
            waiting = queue.waiting(session, languages=self._languages)
        if not waiting or not self._warm():
            return False
        with self._database.writing() as session:
            claim = queue.claim(session, languages=self._languages)
        if claim is None:
            return False
        try:
            answer = self._carry_out(claim)
        except (SimulatorBroken, StreamBroken, Stopping) as broken:
            _log.error("check_broken", check=claim.check_id, why=str(broken))
            with self._database.writing() as session:
                queue.release(session, claim.check_id, claim.attempt)
            return not self._ended.is_set()
        with self._database.writing() as session:
            stored = queue.finish(session, claim, answer)
        _log.info("checked", check=claim.check_id, ok=answer["ok"], stored=stored)
        return True

    def _carry_out(self, claim: CheckClaim) -> dict[str, object]:
        job = Job(
            benchmark=claim.benchmark,
            config=claim.config,
            seeds=(queue.SEED,),
            shown_seed=queue.SEED,
            controller="upload",
            program=store.path(self._settings.data, claim.program_sha256),
            filename=claim.program_name,
            language=claim.language,
            check=True,
        )
        glimpse, deadline = Glimpse(), time.monotonic() + MOST_S
        with self._simulator.begin(job) as simulation:
            while True:
                for frame in simulation.read(WAIT_S):
                    if frame.kind is FrameKind.ENDING:
                        return answer_of(job, glimpse.end(frame.json()))
                    _take(glimpse, frame)
                self._mind(deadline)

    def _warm(self) -> bool:
        """Wait until the simulator is ready: before that, other workers should have the check."""
        try:
            while not self._ended.is_set():
                if self._simulator.wait_warm(WAIT_S):
                    return True
        except SimulatorBroken as broken:
            _log.error("check_simulator_broken", why=str(broken))
        return False

    def _mind(self, deadline: float) -> None:
        if self._ended.is_set():
            raise Stopping("the worker shuts down")
        if time.monotonic() > deadline:
            self._simulator.stop()
            raise SimulatorBroken("a check took too long")


def _take(glimpse: Glimpse, frame: Frame) -> None:
    match frame.kind:
        case FrameKind.ROWS:
            glimpse.rows(np.frombuffer(frame.payload, "<f8").reshape(-1, WIDTH))
        case FrameKind.LOG:
            glimpse.log(frame.payload)
        case FrameKind.CUT:
            glimpse.cut(0, "")
        case FrameKind.ERROR:
            raise SimulatorBroken(frame.payload.decode("utf-8", "replace")[-2000:])


def main(place_text: str, languages: str) -> None:
    """Be the lane of one worker."""
    die_with_parent(os.getppid())
    simulator = Simulator(Place.from_text(place_text), settings.data / "compiled")
    lane = Lane(settings, simulator, tuple(filter(None, languages.split(","))))
    signal.signal(signal.SIGTERM, lambda *_: lane.stop())
    lane.serve()


if __name__ == "__main__":
    main(*sys.argv[1:])
