"""A storage that is away for less than ten minutes costs no run its place, nor its data."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.server.database.tables import Run
from seamark.server.monitoring import meters
from seamark.server.programs import check_queue as checks
from seamark.server.runs.data import stored_files
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.record.states import RunState
from seamark.server.settings import Settings
from seamark.server.storage import objects
from seamark.sim.recording.telemetry import INDEX, digest
from seamark.worker.evaluation.local import evaluate_locally
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.service import run_driver
from seamark.worker.service.check_loop import CheckLoop
from seamark.worker.service.claimed_run import evaluate
from seamark.worker.service.run_driver import RunContext
from seamark.worker.zygote.client import Simulator
from tests.cast import Backend
from tests.services import faulty_s3, s3, tables
from tests.services.faulty_s3 import Behaviour, FaultyS3
from tests.worker.conftest import SHORT, wait_until

LEASE_S = 1.0  # the simulation of a long run goes on while a test waits for two of them
PATIENCE_S = 40.0  # less than a request to the storage may take, so that waiting for it shows
LONG = {"levels": [0.0, 0.1, 0.2, 0.3, 0.4], "level_duration_s": 600.0, "settle_s": 1.0}
# Stands in for the simulator of a worker that claims nothing.
IDLE = "import socket, sys; c = socket.socket(fileno=int(sys.argv[1])); c.send(b'ready'); c.recv(1)"
DOWN: tuple[Behaviour, ...] = ("answers errors", "hangs")


@pytest.fixture
def short_requests(monkeypatch: Any) -> None:
    """Requests that give up after a second, and are sent twice, not four times."""
    for limit in ("REQUEST", "SILENCE"):
        monkeypatch.setattr(objects, limit, timedelta(seconds=1))
    monkeypatch.setattr(objects, "_PROBE", timedelta(seconds=0.5))
    monkeypatch.setattr(objects, "_RETRY", objects._RETRY | {"max_retries": 1})


@pytest.fixture
def storage(s3_server: s3.Server) -> Iterator[FaultyS3]:
    with faulty_s3.in_front_of(s3_server.endpoint) as proxy:
        yield proxy


@pytest.fixture
def backend(
    settings: Settings, s3_server: s3.Server, storage: FaultyS3, tmp_path: Path
) -> Iterator[Backend]:
    """The cast of a service with object storage, whose leases are short."""
    shared = s3_server.settings(tmp_path.name) | {"storage_endpoint": storage.endpoint}
    short = {"lease_s": LEASE_S}
    settings = Settings.model_validate(settings.model_dump() | shared | short)
    database = tables.create(settings)
    yield Backend.with_cast(database, settings)
    database.close()


@contextmanager
def _evaluating(context: RunContext, claim: Claim) -> Iterator[list[bool]]:
    """Evaluate a run beside the test; what comes of it is in the list when the block has ended."""
    found: list[bool] = []
    thread = threading.Thread(target=lambda: found.append(evaluate(context, claim)))
    thread.start()
    yield found
    thread.join(PATIENCE_S)
    assert not thread.is_alive()


def _run(backend: Backend, run_id: int) -> Run:
    with backend.database.reading() as session:
        return session.get_one(Run, run_id)


def _outlives_its_first_lease(backend: Backend, run_id: int) -> None:
    """Wait until a run has been renewed for longer than a lease lasts."""
    until = time.time() + 2 * LEASE_S
    wait_until(lambda: (_run(backend, run_id).lease_until or 0.0) > until, PATIENCE_S)


def _lost(reason: str) -> float:
    return sum(
        meters.REGISTRY.get_sample_value(
            "seamark_attempts_lost_total", {"reason": reason, "state": state}
        )
        or 0.0
        for state in ("queued", "failed")
    )


@pytest.mark.parametrize("behaviour", DOWN)
def test_a_run_keeps_its_lease_while_the_storage_is_away(
    backend: Backend, context: RunContext, storage: FaultyS3, behaviour: Behaviour
) -> None:
    claim = backend.running("ann", config=LONG)

    with _evaluating(context, claim) as went_well:
        wait_until(lambda: backend.show(claim.run_id).progress, PATIENCE_S)
        storage.behave(behaviour)
        wait_until(lambda: storage.asked, PATIENCE_S)
        _outlives_its_first_lease(backend, claim.run_id)
        assert backend.show(claim.run_id).state is RunState.RUNNING
        storage.behave("works")
        backend.cancel(claim.run_id)

    ended = backend.show(claim.run_id)
    assert (went_well, ended.state, ended.attempt) == ([True], RunState.CANCELLED, 1)
    rows = stored_files.of_run(backend.settings, ended).rows()
    assert rows[-1][INDEX["t"]] > 0.0


@pytest.mark.parametrize("behaviour", DOWN)
def test_a_run_that_ends_while_the_storage_is_away_has_its_result_when_it_is_back(
    backend: Backend, context: RunContext, storage: FaultyS3, behaviour: Behaviour
) -> None:
    claim = backend.running("ann", config=SHORT, seed=3)
    storage.behave(behaviour)

    with _evaluating(context, claim) as went_well:
        wait_until(lambda: storage.asked, PATIENCE_S)
        _outlives_its_first_lease(backend, claim.run_id)
        storage.behave("works")

    wanted = evaluate_locally("currents-v1", SHORT, seed=3, controller="pi").digest
    ended = backend.show(claim.run_id)
    assert (went_well, ended.state, ended.attempt) == ([True], RunState.SUCCEEDED, 1)
    assert ended.digest == digest(stored_files.of_run(backend.settings, ended).rows()) == wanted


@pytest.mark.usefixtures("short_requests")
@pytest.mark.parametrize("behaviour", DOWN)
@pytest.mark.parametrize("config", [SHORT, LONG])
def test_a_run_whose_storage_stays_away_is_lost_to_the_storage_not_to_its_worker(
    backend: Backend,
    context: RunContext,
    storage: FaultyS3,
    behaviour: Behaviour,
    config: dict[str, Any],
    monkeypatch: Any,
) -> None:
    monkeypatch.setattr(run_driver, "STORE_AWAY_S", 1.5)
    claim = backend.running("ann", config=config)
    before = {reason: _lost(reason) for reason in ("storage_failed", "worker_lost")}
    storage.behave(behaviour)

    with _evaluating(context, claim) as went_well:
        wait_until(lambda: backend.show(claim.run_id).state is RunState.QUEUED, PATIENCE_S)
        storage.behave("works")

    assert went_well == [False]
    assert _lost("storage_failed") == before["storage_failed"] + 1
    assert _lost("worker_lost") == before["worker_lost"]
    assert _run(backend, claim.run_id).failures == 0


def test_a_claimed_run_keeps_its_lease_while_its_program_cannot_be_fetched(
    backend: Backend, context: RunContext, storage: FaultyS3
) -> None:
    program = backend.store_program()
    claim = backend.running("ann", controller="upload", program=program)
    for copy in backend.settings.data.rglob(program.sha256):
        copy.unlink()
    storage.behave("hangs")

    with _evaluating(context, claim):
        _outlives_its_first_lease(backend, claim.run_id)
        backend.cancel(claim.run_id)
        storage.behave("works")

    assert backend.show(claim.run_id).attempt == 1


@pytest.mark.slow
def test_a_claimed_check_keeps_its_lease_while_its_program_cannot_be_fetched(
    backend: Backend, storage: FaultyS3, tmp_path: Path
) -> None:
    program = backend.store_program()
    for copy in backend.settings.data.rglob(program.sha256):
        copy.unlink()
    with backend.database.writing() as session:
        checks.enqueue(session, backend.user_id("ann"), "currents-v1", {}, program)
    idle = Simulator(WorkerSlot(IsolationLevel.NONE, None), tmp_path, program=("-c", IDLE))
    stopping = threading.Event()
    loop = CheckLoop(backend.settings, idle, ("python",), stopping, name="w/checks-1")
    storage.behave("hangs in programs")
    thread = threading.Thread(target=loop.serve)
    thread.start()

    def renewed_until() -> float:
        with backend.database.reading() as session:
            return max(checks.leases(session).values(), default=0.0)

    until = time.time() + 2 * LEASE_S
    wait_until(lambda: renewed_until() > until, PATIENCE_S)
    stopping.set()
    thread.join(PATIENCE_S)

    assert not thread.is_alive()
    assert renewed_until() == 0.0


@pytest.mark.usefixtures("short_requests")
def test_readers_of_a_run_do_not_wait_in_turn_for_a_storage_that_hangs(
    backend: Backend, context: RunContext, storage: FaultyS3
) -> None:
    claim = backend.running("ann", config=SHORT)
    assert evaluate(context, claim)
    stored_files.of_run(backend.settings, backend.show(claim.run_id))
    storage.behave("hangs")

    readers = [
        threading.Thread(target=stored_files.latest, args=(backend.settings, claim.run_id + 64))
        for _ in range(40)
    ]
    for reader in readers:
        reader.start()
    until = time.monotonic() + PATIENCE_S  # in turn they would wait for twice as long
    for reader in readers:
        reader.join(max(until - time.monotonic(), 0.0))

    assert not any(reader.is_alive() for reader in readers)
    ended = backend.show(claim.run_id)
    assert len(stored_files.of_run(backend.settings, ended).rows())
