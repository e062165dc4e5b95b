"""Checks of several users at a time."""

import time

import pytest

from seamark.server.programs import check_queue
from seamark.server.programs.check_queue import CheckState, CheckView
from tests.cast import PROGRAM
from tests.worker.conftest import POLL_S, START_S, Service

pytestmark = [pytest.mark.slow, pytest.mark.host]
SLEEPS = b"""
import time
class Controller:
    def __init__(self, config): time.sleep(50)  # a check may take 60 s
    def step(self, observation): return [0.0, 0.0, 0.0, 0.0]
"""
STEPS = PROGRAM.replace(b"...\n    def", b"pass\n    def").replace(b"...", b"return [0, 0, 0, 0]")


def _enqueue(service: Service, who: str, source: bytes) -> int:
    program = service.store_program(source)
    with service.database.writing() as session:
        check_id = check_queue.enqueue(session, service.user_id(who), "currents-v1", {}, program)
    check_queue.wake_worker(service.redis)
    return check_id


def _show(service: Service, check_id: int, who: str) -> CheckView:
    with service.database.reading() as session:
        view = check_queue.show(session, check_id, service.user_id(who))
    assert view is not None
    return view


def _wait(service: Service, check_id: int, who: str, state: CheckState) -> None:
    deadline = time.monotonic() + START_S
    while (found := _show(service, check_id, who).state) is not state:
        assert time.monotonic() < deadline, f"still {found}"
        time.sleep(POLL_S)


def test_a_program_that_sleeps_in_its_check_does_not_delay_the_checks_of_others(
    service: Service,
) -> None:
    service.start_worker()
    sleeping = _enqueue(service, "ann", SLEEPS)
    _wait(service, sleeping, "ann", CheckState.RUNNING)

    for who in ("ben", "eva"):
        _wait(service, _enqueue(service, who, STEPS), who, CheckState.DONE)

    assert _show(service, sleeping, "ann").state is CheckState.RUNNING
