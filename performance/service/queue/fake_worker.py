"""A Celery application whose runs pass the real queue but simulate nothing; see `fake_runs`."""

import os
import time
from collections.abc import Callable
from socket import gethostname
from typing import Any, Self

import numpy as np
from billiard import current_process
from celery.signals import worker_process_init

from performance.service.queue.fake_runs import CLAIMS, NOTHING, RUN_S
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.server.database.result_code import result_code
from seamark.server.messaging import broker
from seamark.server.runs.queue.queue import Claim
from seamark.server.settings import Settings
from seamark.worker.evaluation.job import Job
from seamark.worker.ipc.listener import Listener
from seamark.worker.ipc.outcomes import RunOutcome
from seamark.worker.service.host import Host
from seamark.worker.service.run_loop import RunLoop

settings = Settings.load()
app = broker.celery_app(settings)
_state: dict[str, RunLoop] = {}
_broker = broker.connect(settings)


class TimedLoop(RunLoop):
    """Tells the broker how long each claim took, with its commit [s]."""

    def claim(self) -> Claim | None:
        """Claim the next run."""
        began_at = time.perf_counter()
        claim = super().claim()
        if claim is not None:
            _broker.rpush(CLAIMS, time.perf_counter() - began_at)
        return claim


class Nothing:
    """In the place of a simulator and of its simulation: ends at once, with a score."""

    started, silent_s = True, 0.0
    started_at: float | None = None
    trials = 0

    def start(self) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """Do nothing."""

    def wait_warm(self, timeout_s: float) -> bool:
        """Return that it is warm."""
        return True

    def begin(self, job: Job) -> Self:
        """Return this as the simulation."""
        self.trials = len(job.seeds)
        return self

    def run(self, listener: Listener, watch: Callable[[], None]) -> RunOutcome:
        """Return an outcome; entries of competitions are scored by their trials."""
        time.sleep(float(os.environ.get(RUN_S, "0")))
        common: dict[str, Any] = {"overall": {}, "measures": {}, "level_held": None}
        trials = [
            common | {"trial": at, "score": drawn}
            for at, drawn in enumerate(
                np.random.default_rng().uniform(0, 100, self.trials).tolist()
            )
        ]
        metrics = {"score": 50.0, "score_low": 45.0, "score_high": 55.0, "trials": trials}
        return RunOutcome(metrics=metrics, manifest={}, digest="0" * 64)

    def __enter__(self) -> Self:
        """Return this."""
        return self

    def __exit__(self, *_: object) -> None:
        """Do nothing."""


@app.task(name=broker.WORK)
def work() -> None:
    """Answer a ticket as a worker does."""
    _state["run_loop"].run_next()


@app.task(name=NOTHING)
def nothing() -> None:
    """Do nothing."""


@worker_process_init.connect
def _start(**_: Any) -> None:
    result_code()  # hashes the sources once; a worker proves at its start what it computes
    name = f"fake{os.getppid()}@{gethostname()}"
    host = Host(settings, name, IsolationLevel.NONE, (), ())
    index = int(getattr(current_process(), "index", 0) or 0)
    _state["run_loop"] = TimedLoop(
        app,
        settings,
        host,
        index=index,
        shutting_down=lambda: False,
        simulator=Nothing(),  # type: ignore[arg-type]
    )
