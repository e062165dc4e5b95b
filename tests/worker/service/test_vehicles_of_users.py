"""Runs with a vehicle that their user has uploaded, on a real worker."""

import json
from typing import Any

import pytest
from sqlalchemy import update

from seamark.server.database.tables import Run
from seamark.server.messaging import broker
from seamark.server.programs import check_queue, own_files, vehicles
from seamark.server.runs.record.states import RunState
from seamark.server.runs.showing.views import RunView
from seamark.server.runs.submission import submission, validation
from seamark.server.runs.submission.validation import Submission
from seamark.sim.vehicles import own
from seamark.worker.evaluation.local import evaluate_locally
from tests.cast import PROGRAM, VEHICLE
from tests.worker.conftest import SHORT, Service

pytestmark = [pytest.mark.slow, pytest.mark.host]


def submitted(running: Service, config: dict[str, object] = SHORT) -> int:
    vehicle = running.store_vehicle()
    return running.submit({**config, "vehicle": vehicle.name}, controller="pi", vehicle=vehicle)


def ended_as(running: Service, values: dict[str, object], **sent: Any) -> RunView:
    """Return how a run of ann's ends that was stored with other values than were submitted."""
    wanted = {"benchmark": "currents-v1", "controller": "pi", "viewer": running.viewers["ann"]}
    valid = validation.validate(Submission(**wanted | sent), running.settings)
    with running.database.writing() as session:
        run_id = submission.submit(session, valid, running.settings)
        session.execute(update(Run).where(Run.id == run_id).values(**values))
    assert broker.send_tickets(running.app)
    return running.ended(run_id)


def test_a_vehicle_of_a_user_gives_the_server_the_bytes_of_a_local_run(running: Service) -> None:
    with own.lending(VEHICLE.encode()) as name:
        config = {**SHORT, "vehicle": name}
        here = evaluate_locally("currents-v1", config, seed=3, controller="pi")
    ours = evaluate_locally("currents-v1", SHORT, seed=3, controller="pi")

    run = running.ended(submitted(running))

    assert run.state is RunState.SUCCEEDED
    assert run.digest == here.digest != ours.digest
    assert run.config["kp"] == 0.7  # the default of this vehicle
    whole = running.files(run.id).manifest() or {}
    assert whole["vehicle_file"] == (here.manifest or {})["vehicle_file"]
    assert own_files.with_texts(run.manifest or {}, run, running.settings) == whole
    stored = len(VEHICLE) + running.files(run.id).size()
    assert run.data_bytes == stored


def test_the_next_run_of_a_worker_does_not_know_the_vehicle(running: Service) -> None:
    first = running.ended(submitted(running))
    config = {**SHORT, "vehicle": first.config["vehicle"]}

    run = ended_as(running, {"config": config}, config=SHORT)

    assert (run.state, run.cause) == (RunState.FAILED, "benchmark_error")
    assert "no longer valid" in run.detail["sentence"]


def test_a_vehicle_that_is_no_longer_accepted_fails_its_run_with_a_sentence(
    running: Service,
) -> None:
    vehicle = running.store_vehicle()
    text = VEHICLE.replace("format = 1", "format = 2")
    other = vehicles.save(vehicle.name, text.encode(), running.settings)
    config = {**SHORT, "vehicle": vehicle.name}

    values = {"vehicle_sha256": other.sha256}  # as an older version would have accepted
    run = ended_as(running, values, config=config, vehicle=vehicle)

    assert (run.state, run.cause) == (RunState.FAILED, "benchmark_error")
    assert "format must be 1" in run.detail["sentence"]


def test_a_program_is_checked_with_the_vehicle(running: Service) -> None:
    counting = PROGRAM.replace(b"def step", b"def reset(self, level): ...\n    def step").replace(
        b"observation): ...", b"observation): return [len(observation.thrust) * 0.01, 0, 0, 0]"
    )
    vehicle, program = running.store_vehicle(), running.store_program(counting)
    config, user_id = {**SHORT, "vehicle": vehicle.name}, running.user_id("ann")
    with running.database.writing() as session:
        check_id = check_queue.enqueue(session, user_id, "currents-v1", config, program, vehicle)
    check_queue.wake_worker(running.redis)

    report = running.report_of(check_id)

    assert report["ok"], json.dumps(report)
