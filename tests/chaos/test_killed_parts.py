"""Parts of a worker that die alone: what they worked on is done again at once, by a successor.

Nothing here could wait for the end of a lease, or for maintenance to send a missing ticket. The
tests share a worker, since to start one takes five seconds of CPU time; the last one kills it.
"""

import os
import signal
from collections.abc import Iterator

import pytest
from redis import Redis
from sqlalchemy import delete

from seamark.sandbox.isolation.proc_stats import parent_of, tree
from seamark.server.database.tables import Check, Worker
from seamark.server.messaging import workers
from seamark.server.programs import check_queue
from seamark.server.programs.check_queue import CheckState, CheckView
from seamark.server.runs.record.states import RunState
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings
from seamark.sim.recording.telemetry import INDEX, digest
from seamark.worker.evaluation.local import evaluate_locally
from tests.worker.conftest import LONG, QUICK, SHORT, START_S, P, Service, service_with
from tests.worker.processes import command_line
from tests.worker.service.test_side_processes import eventually, pid_of

pytestmark = [pytest.mark.slow, pytest.mark.host]

CORES = min(len(os.sched_getaffinity(0)), 2)
NEVER = {"lease_s": 3600.0, "workers": CORES, "warm_boxes": 1}  # these must not stay either
MINUTES = {**LONG, "level_duration_s": 60.0}
SLOW_TO_START = b"""
import time
class Controller:
    def __init__(self, config): time.sleep(2.0)
    def reset(self, level): pass
    def step(self, observation): return [0, 0, 0, 0]
"""


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory, _valkey: str) -> Iterator[Service]:
    """A service with a worker of two processes if there are two cores."""
    with Redis.from_url(_valkey) as client:
        client.flushall()
    own = {"data": tmp_path_factory.mktemp("service"), "broker_url": _valkey}
    made = service_with(Settings.model_validate(QUICK | NEVER | own))
    made.start_worker()
    yield made
    made.close()


@pytest.fixture
def two_cores(service: Service) -> Service:
    if CORES < 2:
        pytest.skip("one core: trials run one after the other")
    return service


def _listed(service: Service) -> list[str]:
    with service.database.reading() as session:
        return [worker.name for worker in workers.listed(session) if worker.alive]


def _check(service: Service, check_id: int) -> CheckView:
    with service.database.reading() as session:
        view = check_queue.show(session, check_id, service.user_id("ann"))
    assert view is not None
    return view


def trials_of(service: Service) -> list[int]:
    """The processes of trials: forks of a fork of the worker's simulator."""
    simulators = {
        pid
        for pid in tree(service.workers[0].pid)
        if b"seamark.worker.zygote.process" in command_line(pid)
    }
    forks = {pid for pid in simulators if parent_of(pid) in simulators}
    return sorted(pid for pid in forks if parent_of(pid) in forks)


def _running_in_parallel(service: Service, run_id: int) -> list[int]:
    found: list[int] = []

    def both(view: RunView) -> bool:
        found[:] = trials_of(service)
        assert not view.state.final
        return service.files(run_id).row_count() > 0 and len(found) == 2

    service.wait(run_id, both)
    return found


def test_a_trial_that_is_killed_costs_one_attempt_and_nothing_is_lost(two_cores: Service) -> None:
    run_id = two_cores.submit_program(P, MINUTES, trials=4)

    os.kill(_running_in_parallel(two_cores, run_id)[-1], signal.SIGKILL)
    view = two_cores.ended(run_id)

    assert (view.state, view.attempt) == (RunState.SUCCEEDED, 2)
    rows = two_cores.files(run_id).rows()
    assert digest(rows) == view.digest
    assert rows[:, INDEX["trial"]].tolist() == sorted(rows[:, INDEX["trial"]].tolist())
    assert two_cores.files(run_id).attempts() == [2]  # nothing is left of the dead one
    assert trials_of(two_cores) == []


def test_a_cancel_ends_all_trials_within_two_seconds(two_cores: Service) -> None:
    run_id = two_cores.submit_program(P, LONG, trials=10)
    _running_in_parallel(two_cores, run_id)

    view, seconds = two_cores.time_to_cancel(run_id)

    assert view.state is RunState.CANCELLED
    assert seconds < 2.0
    assert trials_of(two_cores) == []
    assert two_cores.files(run_id).row_count() > 0


def test_two_concurrent_runs_have_the_digest_of_a_local_run(two_cores: Service) -> None:
    wanted = evaluate_locally(
        "currents-v1", SHORT, controller="p", seed=3, trials=3, processes=1
    ).digest

    queued = [two_cores.submit(controller="p", trials=3), two_cores.submit_program(P, trials=3)]
    views = [two_cores.ended(run_id) for run_id in queued]

    assert [view.digest for view in views] == [wanted, wanted]


def test_the_run_of_a_killed_pool_child_is_evaluated_again_before_its_lease_ends(
    service: Service,
) -> None:
    run_id = service.submit(MINUTES, trials=2)
    service.wait(run_id, lambda _: service.files(run_id).row_count() > 0)

    for child in service.pool():  # one of them evaluates it
        os.kill(child, signal.SIGKILL)
    view = service.ended(run_id)

    assert (view.state, view.attempt) == (RunState.SUCCEEDED, 2)


def test_a_check_whose_process_is_killed_is_answered_by_its_successor(service: Service) -> None:
    worker = service.workers[0].pid
    program = service.store_program(SLOW_TO_START)
    with service.database.writing() as session:
        check_id = check_queue.enqueue(session, service.user_id("ann"), "currents-v1", {}, program)
    eventually(lambda: _check(service, check_id).state is CheckState.RUNNING, START_S)

    with service.database.reading() as session:
        lane = session.get_one(Check, check_id).worker or ""
    os.kill(eventually(lambda: pid_of(lane, worker)), signal.SIGKILL)
    report = eventually(lambda: _check(service, check_id).report, START_S)

    assert report["ok"]


def test_a_worker_that_is_replaced_hands_its_run_over_and_its_successor_stays_listed(
    service: Service,
) -> None:
    wanted = evaluate_locally("currents-v1", MINUTES, seed=3, trials=2, controller="pi").digest
    [first] = eventually(lambda: _listed(service), START_S)
    run_id = service.submit(MINUTES, trials=2)
    service.wait(run_id, lambda _: service.files(run_id).row_count() > 0)

    replaced = service.workers.pop()
    replaced.terminate()
    replaced.wait(START_S)
    released = service.show(run_id)
    service.start_worker()
    view = service.ended(run_id)

    assert (released.state, released.attempt) == (RunState.QUEUED, 1)
    assert (view.state, view.digest, view.attempt) == (RunState.SUCCEEDED, wanted, 2)
    [second] = eventually(lambda: _listed(service), START_S)
    assert second != first


def test_a_worker_that_is_stopped_while_it_starts_ends_and_leaves_the_list_alone(
    service: Service,
) -> None:
    [name] = eventually(lambda: _listed(service), START_S)
    another = service.start_worker_anew()  # which takes a while
    eventually(lambda: b"zygote" in b"".join(map(command_line, tree(another.pid))), START_S)

    another.terminate()
    another.wait(START_S)
    service.workers.remove(another)

    assert _listed(service) == [name]


def test_a_worker_that_was_forgotten_is_listed_again(service: Service) -> None:
    [name] = eventually(lambda: _listed(service), START_S)
    with service.database.writing() as session:
        session.execute(delete(Worker))

    assert eventually(lambda: _listed(service), START_S) == [name]


def test_nothing_of_a_worker_outlives_its_main_process(service: Service) -> None:
    run_id = service.submit_program(SLOW_TO_START.decode(), LONG, trials=10)
    service.wait(run_id, lambda _: service.files(run_id).row_count() > 0)
    worker = service.workers[-1]
    started = tree(worker.pid)

    worker.kill()
    worker.wait()

    assert len(started) > 4  # the pool's child, its simulator, the side processes, a box
    assert eventually(lambda: not any(os.path.exists(f"/proc/{pid}") for pid in started))
