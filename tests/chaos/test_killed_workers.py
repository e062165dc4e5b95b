"""Workers that die, on both kinds of service: no run is lost, none finishes twice."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from sqlalchemy import update

from seamark.server.database.tables import Run
from seamark.server.runs.record.states import RunState
from seamark.sim.recording.telemetry import digest
from tests.worker.conftest import SHORT, Service, production, service

__all__ = ["production", "service"]  # the fixtures of the worker's tests
pytestmark = [pytest.mark.slow, pytest.mark.host]
# It waits for seconds in each run, without using a core.
SLOW = """
import time
class Controller:
    def __init__(self, config): pass
    def step(self, observation):
        time.sleep(0.01)
        return 0.5 * observation.error[0], 0.5 * observation.error[1], 0.0, 0.0
"""


@contextmanager
def _unable_to_end(service: Service, run_id: int) -> Iterator[None]:
    """Lock the row of a run, so that its worker cannot store an end, however fast it is."""
    with service.database.writing() as session:
        running = update(Run).where(Run.id == run_id, Run.state == RunState.RUNNING)
        locked = session.scalars(running.values(title=Run.title).returning(Run.id)).all()
        assert locked == [run_id]
        yield


def _killed_in_the_middle(service: Service) -> None:
    service.start_worker()
    run_id = service.submit_program(SLOW, SHORT | {"level_duration_s": 6.0})
    service.wait(run_id, lambda _: service.files(run_id).row_count() > 0)
    with _unable_to_end(service, run_id):
        service.kill_worker()

    service.start_worker()
    view = service.ended(run_id)

    assert (view.state, view.attempt) == (RunState.SUCCEEDED, 2)
    again = service.ended(service.submit(SHORT, controller="p"))
    assert again.state is RunState.SUCCEEDED
    assert digest(service.files(run_id).rows()) == view.digest
    assert service.files(run_id).attempts() == [2]  # nothing is left of the dead one


@pytest.mark.long  # with SQLite, test_killed_parts.py kills parts of a worker in all suites
def test_a_run_whose_worker_was_killed_finishes_once(service: Service) -> None:
    _killed_in_the_middle(service)


def test_a_run_whose_worker_was_killed_finishes_once_in_production(production: Service) -> None:
    _killed_in_the_middle(production)
