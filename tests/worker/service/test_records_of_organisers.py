"""A competition in its organiser's record of currents, on a real worker."""

import pytest

from seamark.server.database.tables import Run
from seamark.server.judging import check
from seamark.server.messaging import broker
from seamark.server.programs import own_files
from seamark.server.runs.record.states import RunState
from seamark.sim.physics.water_motion import records
from seamark.worker.evaluation.local import evaluate_locally
from tests.cast import RECORD
from tests.server.judging.cup import Cup
from tests.worker.conftest import SHORT, Service

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
    with records.lending(RECORD.encode()) as name:
        config = {**ended[1].config, "current_record": name}
        here = evaluate_locally("currents-v1", config, seed=seed, trials=3, controller="pi")
    still = {**ended[1].config, "current_record": "none"}
    without = evaluate_locally("currents-v1", still, seed=seed, trials=3, controller="pi")

    assert [run.state for run in ended] == [RunState.SUCCEEDED, RunState.SUCCEEDED]
    assert ended[1].digest == here.digest != without.digest
    whole = running.files(pi).manifest() or {}
    assert whole["current_file"] == {"sha256": record.sha256, "text": RECORD}
    assert own_files.with_texts(ended[1].manifest or {}, ended[1], running.settings) == whole
    assert not records.is_known(name)


def test_the_next_run_of_a_worker_does_not_know_the_record(running: Service) -> None:
    record = running.store_record()
    config = {**SHORT, "current_record": record.name}
    first = running.ended(running.submit(config, files=(record,)))
    assert first.state is RunState.SUCCEEDED

    with records.lending(RECORD.encode()):
        lost = running.submit(config)
    run = running.ended(lost)

    assert (run.state, run.cause) == (RunState.FAILED, "benchmark_error")
