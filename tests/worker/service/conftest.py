"""What evaluates the runs of a worker in the process of a test."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
from redis import Redis

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.service.run_driver import RunContext
from seamark.worker.zygote.client import Simulator
from tests.cast import Backend
from tests.services import forked_workers


@pytest.fixture(scope="session")
def simulator(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Simulator]:
    slot = WorkerSlot(IsolationLevel.NONE, None)
    mother = forked_workers.mother(slot)
    slot = replace(slot, mother=mother.descriptor)
    made = Simulator(slot, tmp_path_factory.mktemp("compiled"))
    made.start()
    yield made
    made.stop()
    mother.stop()


@pytest.fixture
def context(backend: Backend, simulator: Simulator) -> Iterator[RunContext]:
    redis = Redis.from_url(backend.settings.broker_url)
    yield RunContext(
        settings=backend.settings,
        database=backend.database,
        redis=redis,
        simulator=simulator,
        isolation=IsolationLevel.NONE,
        shutting_down=lambda: False,
    )
    redis.close()
