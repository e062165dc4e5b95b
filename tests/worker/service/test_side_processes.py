"""The processes beside a worker's pool: whatever kills one, it runs again, and its state shows."""

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from typing import TypeVar

import pytest
from sqlalchemy import update

from seamark.sandbox.isolation.proc_stats import tree
from seamark.server.database.tables import Worker
from seamark.server.messaging import workers
from seamark.server.messaging.workers import WorkerStatus
from seamark.server.programs import check_queue
from seamark.server.programs.check_queue import CheckState
from seamark.server.runs.record.states import RunState
from seamark.worker.service import ping
from seamark.worker.service.side_processes import SideProcesses
from tests.cast import PROGRAM
from tests.worker.conftest import POLL_S, START_S, Service
from tests.worker.processes import children, command_line

MARKS = {  # side process -> a part of its command line
    "maintenance": "seamark.worker.service.maintenance",
    "checks-1": "/checks-1",
    "checks-2": "/checks-2",
}
DIES = ["-c", "raise SystemExit(3)"]
LIVES = ["-c", "import time; time.sleep(600)"]
IGNORES = ["-c", "import signal, time; signal.signal(15, signal.SIG_IGN); time.sleep(600)"]
SLEEPS = b"""
import time
class Controller:
    def __init__(self, config): time.sleep(50)  # a check may take 60 s
    def step(self, observation): return [0.0, 0.0, 0.0, 0.0]
"""
STEPS = PROGRAM.replace(b"...\n    def", b"pass\n    def").replace(b"...", b"return [0, 0, 0, 0]")
_Found = TypeVar("_Found")


def eventually(find: Callable[[], _Found | None], seconds: float = 60.0) -> _Found:
    """Return what `find` finds, as soon as it does."""
    deadline = time.monotonic() + seconds
    while not (found := find()):
        assert time.monotonic() < deadline, "it did not happen"
        time.sleep(POLL_S)
    return found


def pid_of(mark: str, worker: int) -> int | None:
    """Return the side process of a worker with a mark; None while there is none."""
    found = [pid for pid in tree(worker) if mark.encode() in command_line(pid)]
    return found[0] if found else None


def status(service: Service) -> WorkerStatus | None:
    with service.database.reading() as session:
        listed = workers.listed(session)
    return listed[0] if listed else None


def is_running(service: Service) -> WorkerStatus | None:
    found = status(service)
    return found if found and set(found.processes.values()) == {workers.RUNNING} else None


@pytest.mark.slow
@pytest.mark.host
@pytest.mark.parametrize("name", list(MARKS))
def test_a_side_process_that_is_killed_runs_again_and_its_worker_stays_alive(
    running: Service, name: str
) -> None:
    worker = running.workers[0].pid
    killed = eventually(lambda: pid_of(MARKS[name], worker))

    os.kill(killed, signal.SIGKILL)
    restarting = eventually(
        lambda: (now := status(running)) and now.broken_processes.get(name), seconds=10.0
    )
    started = eventually(lambda: pid_of(MARKS[name], worker))

    assert restarting.startswith("restarting since ")
    assert started != killed
    assert eventually(lambda: is_running(running)).alive


@pytest.mark.slow
@pytest.mark.host
def test_a_run_without_a_ticket_is_evaluated_even_after_maintenance_was_killed(
    running: Service,
) -> None:
    worker = running.workers[0].pid
    run_id = running.queue()  # only maintenance sends its ticket

    os.kill(eventually(lambda: pid_of(MARKS["maintenance"], worker)), signal.SIGKILL)

    assert running.ended(run_id).state is RunState.SUCCEEDED


@pytest.mark.slow
@pytest.mark.host
def test_the_health_check_tells_a_worker_that_hangs(
    running: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = running.settings
    without_broker = settings.model_copy(update={"broker_url": "redis://127.0.0.1:1/0"})
    eventually(lambda: ping.problem(settings) is None)

    monkeypatch.setattr(ping, "ANSWER_S", 1.0)
    os.kill(running.workers[0].pid, signal.SIGSTOP)
    try:
        silent = ping.problem(settings)
        with running.database.writing() as session:
            session.execute(update(Worker).values(seen_at=Worker.seen_at - 2 * workers.ALIVE_S))
        old = ping.problem(without_broker)
    finally:
        os.kill(running.workers[0].pid, signal.SIGCONT)

    assert silent == "no worker of this host has answered within 1 s"
    assert str(old).startswith("the last heartbeat is ")
    eventually(lambda: ping.problem(settings) is None)


def _enqueue(service: Service, who: str, source: bytes) -> int:
    program = service.store_program(source)
    with service.database.writing() as session:
        check_id = check_queue.enqueue(session, service.user_id(who), "currents-v1", {}, program)
    check_queue.wake_worker(service.redis)
    return check_id


def _state(service: Service, check_id: int, who: str) -> CheckState:
    with service.database.reading() as session:
        view = check_queue.show(session, check_id, service.user_id(who))
    assert view is not None
    return view.state


def _wait(service: Service, check_id: int, who: str, state: CheckState) -> None:
    eventually(lambda: _state(service, check_id, who) is state, START_S)


@pytest.mark.slow
@pytest.mark.host
def test_a_program_that_sleeps_in_its_check_does_not_delay_the_checks_of_others(
    running: Service,
) -> None:
    sleeping = _enqueue(running, "ann", SLEEPS)
    _wait(running, sleeping, "ann", CheckState.RUNNING)

    for who in ("ben", "eva"):
        _wait(running, _enqueue(running, who, STEPS), who, CheckState.DONE)

    assert _state(running, sleeping, "ann") is CheckState.RUNNING


class Reports:
    """Keeps the states that are reported."""

    def __init__(self) -> None:
        self.states: list[dict[str, str]] = []
        self.fails = False
        self.left_after = 0  # how many reports

    def leave(self) -> None:
        self.left_after = len(self.states)
        if self.fails:
            raise OSError("the database is away")

    def __call__(self, states: dict[str, str]) -> None:
        self.states.append(states)
        if self.fails:
            raise OSError("the database is away")

    def latest_if_broken(self, count: int) -> list[dict[str, str]]:
        """Return the last reports if they all say that the process is broken."""
        latest = self.states[-count:]
        broken = [state for state in latest if state["broken"].startswith("restarting since ")]
        return broken if len(broken) == count else []


@pytest.fixture
def reports() -> Reports:
    return Reports()


@pytest.fixture
def started(reports: Reports) -> Iterator[Callable[[dict[str, list[str]]], SideProcesses]]:
    made: list[SideProcesses] = []

    def start(commands: dict[str, list[str]]) -> SideProcesses:
        made.append(SideProcesses(commands, reports, leave=reports.leave, report_s=0.1))
        made[0].start()
        return made[0]

    yield start
    made[0].stop()
    made[0].join()


@pytest.mark.slow
def test_a_side_process_that_always_dies_at_once_shows_as_broken_and_the_other_runs(
    started, reports: Reports
) -> None:
    started({"broken": DIES, "fine": LIVES})

    latest = eventually(lambda: reports.latest_if_broken(12))

    assert len({state["broken"] for state in latest}) == 1  # since its first death
    assert {state["fine"] for state in reports.states} == {"running"}


@pytest.mark.slow
def test_a_report_that_fails_ends_nothing(started, reports: Reports) -> None:
    reports.fails = True
    started({"fine": LIVES})

    eventually(lambda: len(reports.states) > 3)


@pytest.mark.parametrize("command", [LIVES, IGNORES], ids=["ends", "ignores SIGTERM"])
def test_a_stop_ends_all_side_processes(started, reports: Reports, command: list[str]) -> None:
    before = children()
    side_processes = started({"one": command, "other": command})
    eventually(lambda: reports.states)

    side_processes.stop()
    side_processes.join()

    assert children() == before
    assert reports.left_after == len(reports.states)


@pytest.mark.slow
def test_a_fork_never_inherits_the_locks_of_the_watching_thread() -> None:
    held, reporting = threading.Lock(), threading.Event()

    def report(_: dict[str, str]) -> None:
        with held:
            reporting.set()
            time.sleep(0.05)

    side_processes = SideProcesses({"fine": LIVES}, report, leave=int, report_s=0.0)
    side_processes.start()
    try:
        statuses = [_status_of_fork_in(reporting, held) for _ in range(10)]
    finally:
        side_processes.stop()
        side_processes.join()

    assert statuses == [0] * 10


def _status_of_fork_in(reporting: threading.Event, held: threading.Lock) -> int:
    """Fork while the thread reports; return 0 if the fork found the lock free."""
    reporting.clear()
    assert reporting.wait(30.0)
    pid = os.fork()
    if pid == 0:
        os._exit(int(held.locked()))
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
