"""A competition with its organiser's record of currents or target picture, on a real worker."""

from typing import Any

import pytest

from seamark.server.database.tables import Run
from seamark.server.judging import check
from seamark.server.messaging import broker
from seamark.server.programs import own_files
from seamark.server.runs.record.states import RunState
from seamark.sim.files import target_pictures
from seamark.sim.physics.water_motion import records
from seamark.worker.evaluation.local import evaluate_locally
from tests.cast import RECORD
from tests.server.judging.cup import Cup
from tests.worker.conftest import SHORT, Service

TRACKING = {"level_duration_s": 2.0, "turbidity_levels": [0.0, 7.0], "motion_levels": [2.0, 8.0]}
pytestmark = [pytest.mark.slow, pytest.mark.host]


def test_an_entry_gives_the_bytes_of_a_local_run_with_the_file(
    running: Service,
) -> None:
    record = running.store_record()
    cup = Cup.draft(running, files=(record,), settings=SHORT)
    with running.database.writing() as session:
        check.request(session, cup.view, running.settings)
    p, pi = cup.live()
    assert broker.send_tickets(running.app)

    ended = [running.ended(run_id) for run_id in (p, pi)]
    with running.database.reading() as session:
        seed = session.get_one(Run, pi).seed or 0
    with records.LIBRARY.lending(RECORD.encode()) as name:
        config = {**ended[1].config, "current_record": name}
        here = evaluate_locally("currents-v1", config, seed=seed, trials=3, controller="pi")
    still = {**ended[1].config, "current_record": "none"}
    without = evaluate_locally("currents-v1", still, seed=seed, trials=3, controller="pi")

    assert [run.state for run in ended] == [RunState.SUCCEEDED, RunState.SUCCEEDED]
    assert ended[1].digest == here.digest != without.digest
    whole = running.files(pi).manifest() or {}
    assert whole["current_file"] == {"sha256": record.sha256, "text": RECORD}
    assert own_files.with_texts(ended[1].manifest or {}, ended[1], running.settings) == whole
    assert not records.LIBRARY.is_known(name)


def test_a_run_with_a_target_picture_gives_the_bytes_of_a_local_run(running: Service) -> None:
    picture = running.store_picture()
    config = {**TRACKING, "target_texture": picture.name}
    chosen: Any = {"benchmark": "visibility-v2", "controller": "built-in"}
    run_id = running.submit(config, files=(picture,), **chosen)

    run = running.ended(run_id)
    facts: Any = {"seed": 3, "trials": run.trials, "controller": run.controller}
    with target_pictures.LIBRARY.lending(picture.content):
        here = evaluate_locally("visibility-v2", run.config, **facts)
    mixed = evaluate_locally("visibility-v2", {**run.config, "target_texture": "mixed"}, **facts)

    assert run.state is RunState.SUCCEEDED
    assert run.digest == here.digest != mixed.digest
    manifest = running.files(run_id).manifest() or {}
    text = picture.content.decode()
    assert manifest["target_file"] == {"sha256": picture.sha256, "text": text}


def test_the_next_run_of_a_worker_does_not_know_the_record(running: Service) -> None:
    record = running.store_record()
    config = {**SHORT, "current_record": record.name}
    first = running.ended(running.submit(config, files=(record,)))
    assert first.state is RunState.SUCCEEDED

    with records.LIBRARY.lending(RECORD.encode()):
        lost = running.submit(config)
    run = running.ended(lost)

    assert (run.state, run.cause) == (RunState.FAILED, "benchmark_error")
