"""A cancelled run stops with its boxes, whatever it was doing."""

import time
from collections.abc import Iterator

import pytest
from redis import Redis

from seamark.sandbox.isolation.proc_stats import tree
from seamark.server.runs.states import RunState
from seamark.server.settings import Settings
from tests.worker.conftest import QUICK, SHORT, Service, service_with
from tests.worker.processes import command_line

pytestmark = [pytest.mark.slow, pytest.mark.host]

FOREVER_S = 60.0  # [s] at least, until something else than a cancel ends these
SLEEP = "import time\nclass Controller:\n def __init__(s, c): {start}\n def reset(s, l): pass\n"
SLEEP += " def step(s, o): {step}\n"
DOUBLE = "".join(f"#define A{n} A{n - 1} A{n - 1}\n" for n in range(1, 40))
PROGRAMS = {
    "compiling": ("mine.c", f"#define A0 x+\n{DOUBLE}int x; int f(void) {{ return A39 0; }}\n"),
    "starting": ("mine.py", SLEEP.format(start="time.sleep(170)", step="pass")),
    "stepping": ("mine.py", SLEEP.format(start="print('started')", step="time.sleep(170)")),
}


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory, _valkey: str) -> Iterator[Service]:
    """A worker that keeps no box ready, so that each box is that of a run."""
    with Redis.from_url(_valkey) as client:
        client.flushall()
    own = {"data": tmp_path_factory.mktemp("service"), "broker_url": _valkey, "warm_boxes": 0}
    made = service_with(Settings.model_validate(QUICK | own))
    made.start_worker()
    yield made
    made.close()


def _boxes(service: Service) -> list[int]:
    return [pid for pid in tree(service.workers[0].pid) if b"bwrap" in command_line(pid)]


@pytest.mark.parametrize("doing", PROGRAMS)
def test_a_cancel_ends_the_run_and_its_box(service: Service, doing: str) -> None:
    name, source = PROGRAMS[doing]
    program = service.store_program(source.encode(), name)
    run_id = service.submit(SHORT, controller="upload", program=program)
    service.wait(run_id, lambda view: view.state is RunState.RUNNING and bool(_boxes(service)))
    if doing == "stepping":
        service.wait(run_id, lambda _: "started" in service.files(run_id).log_text())

    view, seconds = service.time_to_cancel(run_id)
    while _boxes(service):
        assert time.monotonic()
    print(seconds)
    assert view.state is RunState.CANCELLED
    assert seconds < FOREVER_S
