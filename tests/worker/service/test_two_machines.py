"""Web and workers on machines that share a database, a broker and object storage, but no folder."""

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.server.runs.data import run_objects, stored_files
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.record.states import RunState
from seamark.server.settings import Settings
from seamark.server.storage import objects
from seamark.sim.recording.telemetry import digest
from seamark.worker.evaluation.local import evaluate_locally
from tests.services import s3
from tests.worker.conftest import QUICK, SHORT, Service, service_with

PROGRAM = """
class Controller:
    def __init__(self, config):
        print("here")
    def step(self, observation):
        return 0.5 * observation.error[0], 0.5 * observation.error[1], 0.0, 0.0
"""
# It waits for seconds in each run, without using a core.
SLOW = PROGRAM.replace("        return", "        time.sleep(0.02)\n        return")
SLOW = f"import time\n{SLOW}"


@pytest.fixture
def machines(settings: Settings, s3_server: s3.Server, tmp_path: Path) -> Iterator[Service]:
    """A service without a worker, whose web process has a machine of its own."""
    shared = s3_server.settings(tmp_path.name) | QUICK | {"seed_key": "of the tests"}
    made = service_with(Settings.model_validate(settings.model_dump() | shared))
    yield made
    made.close()


def _start_worker(service: Service, name: str) -> None:
    """Start a worker on a machine of its own."""
    web = service.settings
    service.settings = web.model_copy(update={"data": web.data.with_name(name)})
    service.settings.data.mkdir()
    try:
        service.start_worker()
    finally:
        service.settings = web


def _files(service: Service, run_id: int) -> RunFiles:
    return stored_files.of_run(service.settings, service.show(run_id))


# Two workers start, each on a machine of its own. Short: `test_storage_blips` reads what another
# process has stored, and `test_killed_parts` of the chaos tests kills parts of a worker.
@pytest.mark.long
def test_a_run_on_another_machine_is_read_here_and_ends_on_a_third_if_its_worker_dies(
    machines: Service, isolation: IsolationLevel
) -> None:
    program = machines.store_program(PROGRAM.encode())
    expected = evaluate_locally(
        "currents-v1", SHORT, seed=3, controller=(PROGRAM.encode(), "mine.py"), isolation=isolation
    ).digest
    _start_worker(machines, "first")
    uploaded = machines.ended(machines.submit(controller="upload", program=program))
    # So slow that it does not end before its first rows are seen here.
    long = machines.submit_program(SLOW, SHORT | {"level_duration_s": 10.0})
    machines.wait(long, lambda run: run.state is RunState.RUNNING)
    deadline = time.monotonic() + 120
    while not stored_files.latest(machines.settings, long).row_count():
        assert time.monotonic() < deadline
        time.sleep(0.1)  # parts are not announced

    machines.kill_worker()
    _start_worker(machines, "second")
    again = machines.ended(long)

    files = _files(machines, uploaded.id)
    assert uploaded.digest == digest(files.rows()) == expected
    assert files.log_text() == "here\n"
    assert (again.state, again.attempt) == (RunState.SUCCEEDED, 2)
    assert digest(_files(machines, long).rows()) == again.digest
    stored = objects.of(machines.settings)
    assert stored is not None
    assert list(run_objects.attempts(stored, long)) == [2]
