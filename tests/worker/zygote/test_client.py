"""A worker whose simulator is still being compiled, with a stand-in that is warm on command."""

import os
import socket
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from seamark.sandbox.isolation.cgroup_parents import parent_groups
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.proc_stats import tree
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.ipc import messages
from seamark.worker.ipc.messages import BoxFailed, Crashed, RunEnded, Started
from seamark.worker.ipc.outcomes import RunOutcome
from seamark.worker.zygote import client
from seamark.worker.zygote.client import BoxBroken, Mother, Simulation, Simulator, SimulatorBroken
from tests.services import forked_workers
from tests.worker.evaluation.fakes import FakeListener
from tests.worker.service.test_side_processes import eventually

COMPILED_S = 900.0  # a first start compiles the simulator, on a busy machine for many minutes
# Started as `seamark.worker.zygote.process` is; it is warm as soon as a test
# writes to the named pipe.
SLOW = """
import os, socket, sys
control = socket.socket(fileno=int(sys.argv[1]))
with open(os.environ["SLOW_START"]) as start:
    if start.read() == "fail":
        sys.exit(1)
control.send(b"ready")
control.recv(1)
"""


@pytest.fixture
def start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The named pipe that the stand-in waits for."""
    path = tmp_path / "start"
    os.mkfifo(path)
    monkeypatch.setenv("SLOW_START", str(path))
    return path


@pytest.fixture
def simulator(start: Path, tmp_path: Path) -> Iterator[Simulator]:
    program = tmp_path / "slow.py"
    program.write_text(SLOW)
    made = Simulator(WorkerSlot(IsolationLevel.NONE, None), tmp_path, program=(str(program),))
    yield made
    made.stop()


def test_a_simulator_is_warm_when_it_says_so(simulator: Simulator, start: Path) -> None:
    assert not simulator.wait_warm(0.0)

    start.write_text("go")

    assert simulator.wait_warm(30.0)
    assert simulator.wait_warm(0.0)


def test_a_simulator_that_ends_during_its_start_is_a_failure_of_the_platform(
    simulator: Simulator, start: Path
) -> None:
    assert not simulator.wait_warm(0.0)

    start.write_text("fail")

    with pytest.raises(SimulatorBroken):
        simulator.wait_warm(30.0)


@pytest.mark.parametrize(
    ("message", "kind"), [(BoxFailed("no room"), BoxBroken), (Crashed("no room"), SimulatorBroken)]
)
def test_a_box_that_fails_is_told_from_a_simulator_that_crashes(
    message: BoxFailed | Crashed, kind: type[SimulatorBroken]
) -> None:
    ours, childs = socket.socketpair()
    with childs, Simulation(ours) as simulation:
        messages.send(childs, message)
        with pytest.raises(SimulatorBroken, match="no room") as raised:
            simulation.run(FakeListener(), lambda: None)

    assert raised.type is kind


@pytest.mark.slow
@pytest.mark.timeout(COMPILED_S + 60)
def test_a_run_that_is_over_before_anybody_has_read_of_its_start_has_its_outcome() -> None:
    gone = subprocess.Popen(["true"])
    gone.wait()
    ours, childs = socket.socketpair()
    messages.send(childs, Started(gone.pid))
    messages.send(childs, RunEnded(RunOutcome(digest="0" * 64)))
    childs.close()

    with Simulation(ours) as simulation:
        outcome = simulation.run(FakeListener(), lambda: None)

    assert outcome.digest == "0" * 64
    assert simulation.started


def test_a_child_that_dies_without_an_outcome_is_a_failure_of_the_platform() -> None:
    gone = subprocess.Popen(["true"])
    gone.wait()
    ours, childs = socket.socketpair()
    messages.send(childs, Started(gone.pid))
    childs.close()

    with Simulation(ours) as simulation, pytest.raises(SimulatorBroken, match="died"):
        simulation.run(FakeListener(), lambda: None)


@pytest.mark.slow
@pytest.mark.long  # each test with `simulator` of tests/worker/service waits for a real one
def test_the_real_simulator_says_when_it_is_warm(tmp_path: Path) -> None:
    simulator = Simulator(WorkerSlot(IsolationLevel.NONE, None), tmp_path)

    warm = simulator.wait_warm(COMPILED_S)
    simulator.stop()

    assert warm


@pytest.mark.host
@pytest.mark.timeout(COMPILED_S + 240)
def test_a_simulator_that_is_stopped_during_a_run_leaves_no_control_group(
    tmp_path: Path, isolation: IsolationLevel, monkeypatch: pytest.MonkeyPatch
) -> None:
    if isolation is not IsolationLevel.STRONG:
        pytest.skip("needs control groups")
    # It removes its boxes itself, however long it takes to start the last of them first.
    monkeypatch.setattr(client, "STOP_WITHIN_S", 120.0)
    program = tmp_path / "sleeps.py"
    program.write_text("import time\ntime.sleep(60)\nclass Controller: ...")
    job = Job(
        benchmark="currents-v1",
        config={},
        seeds=(1, 2),
        controller="upload",
        program=program,
        filename=program.name,
    )
    slot = WorkerSlot(isolation, None, languages=("python", "c"), warm_boxes=1)
    mother = forked_workers.mother(slot)
    simulator = Simulator(replace(slot, mother=mother.descriptor), tmp_path)
    assert simulator.wait_warm(COMPILED_S)
    owner = eventually(lambda: zygote_with_box(mother))

    with simulator.begin(job):
        simulator.stop()
    mother.stop()

    assert groups_of(owner) == []


def zygote_with_box(mother: Mother) -> int | None:
    """Return the pid of a child of a mother that has a box in each hierarchy, or more."""
    return next((pid for pid in tree(mother._process.pid) if groups_of(pid)), None)


def groups_of(pid: int) -> list[Path]:
    return [
        group
        for folder in parent_groups().folders()
        for group in folder.glob(f"seamark-box-{pid}-*")
    ]
