"""A cancelled run stops with its box, whatever it was doing; and nothing of it stays open."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from redis import Redis

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.proc_stats import tree
from seamark.server.runs.record.states import RunState
from seamark.server.settings import Settings
from seamark.worker.ipc.outcomes import RunOutcome
from seamark.worker.service.claimed_run import evaluate
from seamark.worker.service.run_driver import RunContext
from tests.cast import Backend
from tests.worker.conftest import LONG, QUICK, SHORT, START_S, Service, service_with
from tests.worker.processes import command_line
from tests.worker.service.test_side_processes import eventually

LOST_S = 60.0  # [s] what these programs do lasts longer: a cancel that is lost takes more than this
CONTROLLER = """
import time
class Controller:
    def __init__(self, config): time.sleep({start_s})
    def reset(self, level): pass
    def step(self, observation): return [0, 0, 0, 0]
"""
DOUBLED = "".join(f"#define A{n} A{n - 1} A{n - 1}\n" for n in range(1, 40))
PROGRAMS = {
    "compiling": ("mine.c", f"#define A0 x+\n{DOUBLED}int x; int f(void) {{ return A39 0; }}\n"),
    "starting": ("mine.py", CONTROLLER.format(start_s=170)),
    "stepping": ("mine.py", CONTROLLER.format(start_s=0)),
}


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory, _valkey: str) -> Iterator[Service]:
    """A worker that keeps no box ready, so that each box is that of a run."""
    with Redis.from_url(_valkey) as client:
        client.flushall()
    own = {"data": tmp_path_factory.mktemp("service"), "broker_url": _valkey}
    made = service_with(Settings.model_validate(QUICK | own))
    made.start_worker()
    yield made
    made.close()


def _boxes(service: Service) -> list[int]:
    return [pid for pid in tree(service.workers[0].pid) if b"bwrap" in command_line(pid)]


@pytest.mark.slow
@pytest.mark.host
@pytest.mark.parametrize("doing", PROGRAMS)
def test_a_cancel_ends_the_run_and_its_box(service: Service, doing: str) -> None:
    name, source = PROGRAMS[doing]
    program = service.store_program(source.encode(), name)
    config = LONG if doing == "stepping" else SHORT
    run_id = service.submit(config, controller="upload", program=program, trials=10)
    service.wait(run_id, lambda view: view.state is RunState.RUNNING)
    eventually(lambda: _boxes(service), START_S)
    if doing == "stepping":
        eventually(lambda: service.files(run_id).row_count(), START_S)

    view, seconds = service.time_to_cancel(run_id)

    assert view.state is RunState.CANCELLED
    assert seconds < LOST_S
    assert eventually(lambda: not _boxes(service), START_S)


class Finished:
    """A simulation that has ended, at a moment at which something else happens."""

    started_at = None

    def __init__(self, meanwhile: Callable[[], object]) -> None:
        self._meanwhile = meanwhile

    @contextmanager
    def begin(self, _job: object) -> Iterator["Finished"]:
        yield self

    def run(self, _listener: object, _watch: object) -> RunOutcome:
        self._meanwhile()
        return RunOutcome(metrics={"score": 50.0}, manifest={}, digest="0" * 64)


@pytest.mark.slow
def test_a_run_that_is_cancelled_while_its_result_is_stored_is_closed_as_cancelled(
    backend: Backend, redis_url: str
) -> None:
    claim = backend.running("ann")
    with Redis.from_url(redis_url) as redis:
        context = RunContext(
            settings=backend.settings,
            database=backend.database,
            redis=redis,
            simulator=Finished(lambda: backend.cancel(claim.run_id)),
            isolation=IsolationLevel.NONE,
            shutting_down=lambda: False,
        )
        assert evaluate(context, claim)

    view = backend.show(claim.run_id)
    assert (view.state, view.score) == (RunState.CANCELLED, None)
    assert "t_reached" in view.detail  # as of a run that was cancelled earlier
