"""A disk that fills up, or goes away, costs an attempt and no result."""

import os
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.server.database.tables import Run
from seamark.server.messaging import broker
from seamark.server.programs import store
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.queue import lost_attempts
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.record.states import RunState
from seamark.server.storage import storage
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.local import evaluate_locally
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.service.claimed_run import evaluate, evaluate_or_release
from seamark.worker.service.host import Host
from seamark.worker.service.run_driver import RunContext
from seamark.worker.service.run_loop import RunLoop
from seamark.worker.zygote.client import Simulation, Simulator, SimulatorBroken
from tests.cast import Backend
from tests.services.full_disk import files_end_at
from tests.worker.conftest import SHORT

MORE_THAN_ANY_DISK = 2**62
MINUTES: dict[str, Any] = {"levels": [0.0, 0.1], "level_duration_s": 90.0}  # 1.6 MB
# Stands in for the simulator of a worker that claims nothing.
IDLE = "import socket, sys; c = socket.socket(fileno=int(sys.argv[1])); c.send(b'ready'); c.recv(1)"


class _BrokenSimulator:
    def begin(self, job: Job) -> Simulation:
        raise SimulatorBroken("the simulator child died")


def _with(context: RunContext, **changes: Any) -> RunContext:
    return replace(context, settings=context.settings.model_copy(update=changes))


def _failures(backend: Backend, run_id: int) -> int:
    with backend.database.reading() as session:
        return session.get_one(Run, run_id).failures


def _digest(config: dict[str, Any]) -> str:
    return evaluate_locally("currents-v1", config, seed=3, controller="pi").digest


def test_a_run_stops_when_the_disk_gets_full_and_is_repeated_when_there_is_space(
    backend: Backend, context: RunContext
) -> None:
    claim = backend.running("ann", config=SHORT, seed=3)

    went_well = evaluate(_with(context, free_min_bytes=MORE_THAN_ANY_DISK), claim)

    stopped, files = backend.show(claim.run_id), RunFiles(backend.settings.data, claim.run_id)
    assert (went_well, stopped.state, files.attempts()) == (False, RunState.QUEUED, [])
    assert _failures(backend, claim.run_id) == 0

    assert evaluate(context, backend.claim_next())

    done = backend.show(claim.run_id)
    assert (done.state, done.attempt, done.digest) == (RunState.SUCCEEDED, 2, _digest(SHORT))


def test_telemetry_that_does_not_fit_costs_an_attempt_and_leaves_nothing_half(
    backend: Backend, context: RunContext
) -> None:
    claim = backend.running("ann", config=MINUTES, seed=3)

    with files_end_at(2**20):
        went_well = evaluate(context, claim)

    files = RunFiles(backend.settings.data, claim.run_id)
    assert (went_well, files.attempts()) == (False, [])
    assert backend.show(claim.run_id).state is RunState.QUEUED

    assert evaluate(context, backend.claim_next())

    assert backend.show(claim.run_id).digest == _digest(MINUTES)


def test_a_run_whose_data_never_fit_ends_as_a_failure_of_the_platform(
    backend: Backend, context: RunContext
) -> None:
    claim = backend.running("ann", config=SHORT)
    for _ in range(lost_attempts.INTERRUPTIONS_MAX):
        evaluate(_with(context, free_min_bytes=MORE_THAN_ANY_DISK), claim)
        claim = backend.claim() or claim

    ended = backend.show(claim.run_id)
    assert (ended.state, ended.cause) == (RunState.FAILED, "platform_error")


def test_with_no_room_for_the_database_either_the_run_is_repeated_after_its_lease(
    backend: Backend, context: RunContext
) -> None:
    claim = backend.running("ann", config=SHORT, seed=3)

    with files_end_at(1024):
        went_well = evaluate(context, claim)
    assert (went_well, backend.show(claim.run_id).state) == (False, RunState.RUNNING)

    with backend.database.writing() as session:
        abandoned = lost_attempts.leases(session)
        lost_attempts.recover(session, abandoned, backend.settings)
    assert evaluate(context, backend.claim_next())

    assert backend.show(claim.run_id).digest == _digest(SHORT)


def test_a_new_attempt_removes_the_files_of_the_dead_ones(
    backend: Backend, context: RunContext
) -> None:
    claim = backend.running("ann", config=SHORT)
    RunFiles(backend.settings.data, claim.run_id, claim.attempt).append_log(b"dead")
    with backend.database.writing() as session:
        lost_attempts.recover(session, lost_attempts.leases(session), backend.settings)

    assert evaluate(context, backend.claim_next())

    files = RunFiles(backend.settings.data, claim.run_id)
    assert files.attempts() == [2]
    assert backend.show(claim.run_id).data_bytes == files.size() > 0


@pytest.mark.parametrize("what", ["full", "away", "over its quota"])
def test_a_worker_claims_nothing_while_the_disk_is_full_or_away(
    backend: Backend, tmp_path: Path, what: str
) -> None:
    run_id = backend.queue("ann", config=SHORT)
    changes = {"free_min_bytes": MORE_THAN_ANY_DISK if what == "full" else 1}
    settings = backend.settings.model_copy(update=changes)
    idle = Simulator(WorkerSlot(IsolationLevel.NONE, None), tmp_path, program=("-c", IDLE))
    loop = RunLoop(
        broker.celery_app(settings),
        settings,
        Host(settings, "w", IsolationLevel.NONE, (), ()),
        index=0,
        shutting_down=lambda: False,
        simulator=idle,
    )
    if what == "away":
        os.rename(settings.data, tmp_path / "away")

    with files_end_at(4096) if what == "over its quota" else nullcontext():
        loop.run_next()
    loop.close()

    assert backend.show(run_id).attempt == 0


@pytest.fixture(params=["before the run is released", "later"])
def back(request: pytest.FixtureRequest, monkeypatch: Any) -> None:
    """When the data folder is back: whoever looks then finds nothing wrong any more."""
    if request.param != "later":
        monkeypatch.setattr(storage, "refusal", lambda *_, **__: None)


@pytest.mark.usefixtures("back")
def test_a_run_whose_data_folder_is_away_has_not_failed(
    backend: Backend, context: RunContext
) -> None:
    claim = backend.running("ann", config=SHORT, seed=3)

    went_well = _evaluate_without_data_folder(context, claim)

    assert (went_well, backend.show(claim.run_id).state) == (False, RunState.QUEUED)
    assert _failures(backend, claim.run_id) == 0
    assert evaluate(context, backend.claim_next())
    assert backend.show(claim.run_id).digest == _digest(SHORT)


@pytest.mark.usefixtures("back")
def test_a_run_whose_program_is_away_has_not_failed(backend: Backend, context: RunContext) -> None:
    claim = backend.running("ann", controller="upload", program=backend.store_program())

    went_well = _evaluate_without_data_folder(context, claim)

    assert (went_well, backend.show(claim.run_id).state) == (False, RunState.QUEUED)
    assert _failures(backend, claim.run_id) == 0


def test_a_run_whose_program_alone_is_gone_has_failed(
    backend: Backend, context: RunContext
) -> None:
    program = backend.store_program()
    claim = backend.running("ann", controller="upload", program=program)
    store.path(backend.settings, program.sha256).unlink()

    went_well = evaluate(context, claim)

    assert (went_well, backend.show(claim.run_id).state) == (False, RunState.QUEUED)
    assert _failures(backend, claim.run_id) == 1


@pytest.mark.parametrize(("free_min_bytes", "failures"), [(1, 1), (MORE_THAN_ANY_DISK, 0)])
def test_a_simulator_that_breaks_on_a_full_disk_has_not_failed(
    backend: Backend, context: RunContext, free_min_bytes: int, failures: int
) -> None:
    claim = backend.running("ann", config=SHORT)
    broken: Any = _BrokenSimulator()

    context = replace(_with(context, free_min_bytes=free_min_bytes), simulator=broken)
    went_well = evaluate_or_release(context, claim)

    assert (went_well, backend.show(claim.run_id).state) == (False, RunState.QUEUED)
    assert _failures(backend, claim.run_id) == failures


def _evaluate_without_data_folder(context: RunContext, claim: Claim) -> bool:
    data = context.settings.data
    away = data.rename(data.with_suffix(".away"))
    try:
        return evaluate(context, claim)
    finally:
        away.rename(data)
