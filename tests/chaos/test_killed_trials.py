"""Parallel trials in a real service: a killed one costs an attempt, a cancel ends all."""

import os
import signal
from collections.abc import Iterator

import pytest
from redis import Redis

from seamark.sandbox.isolation.proc_stats import parent_of, tree
from seamark.server.runs.record.states import RunState
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings
from seamark.sim.recording.telemetry import INDEX, digest
from seamark.worker.evaluation.local import evaluate_locally
from tests.worker.conftest import LONG, QUICK, SHORT, Service, service_with
from tests.worker.processes import command_line

pytestmark = [pytest.mark.slow, pytest.mark.host]

TRIALS = {**LONG, "level_duration_s": 100.0}
P = """
class Controller:
    def __init__(self, config):
        self.kp = config["kp"]
    def reset(self, level):
        pass
    def step(self, observation):
        return [self.kp * observation.error[0], self.kp * observation.error[1], 0.0, 0.0]
"""


@pytest.fixture(scope="module")
def two_cores(tmp_path_factory: pytest.TempPathFactory, _valkey: str) -> Iterator[Service]:
    """A service whose worker has two processes."""
    if len(os.sched_getaffinity(0)) < 2:
        pytest.skip("one core: trials run one after the other")
    with Redis.from_url(_valkey) as client:
        client.flushall()
    data = tmp_path_factory.mktemp("service")
    made = service_with(
        Settings.model_validate(QUICK | {"data": data, "broker_url": _valkey, "workers": 2})
    )
    made.start_worker()
    yield made
    made.close()


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
        return view.t_simulated > 0 and len(found) == 2

    service.wait(run_id, both)
    return found


def test_a_trial_that_is_killed_costs_one_attempt_and_nothing_is_lost(two_cores: Service) -> None:
    run_id = two_cores.submit_program(P, TRIALS, trials=4)

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
