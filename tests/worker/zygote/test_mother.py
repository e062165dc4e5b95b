"""Zygotes that a warm mother forks: they are those of a new interpreter, sooner and smaller."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.proc_stats import cpu_s, parent_of, threads, tree
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.local import evaluate_locally
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.zygote import client
from seamark.worker.zygote.client import Mother, Simulator, SimulatorBroken
from tests.services import forked_workers
from tests.services.prepared import printed
from tests.worker.conftest import SHORT
from tests.worker.evaluation.fakes import FakeListener
from tests.worker.processes import children, command_line
from tests.worker.service.test_side_processes import eventually

pytestmark = pytest.mark.slow

COMPILED_S = 900.0  # a first start compiles the simulator, on a busy machine for many minutes
FORKED_S = 30.0  # [s]; a fork of a warm mother takes some milliseconds
ALONE = WorkerSlot(IsolationLevel.NONE, None)
JOB = Job(benchmark="currents-v1", config=SHORT, seeds=(3,), controller="p")
# A zygote of a new interpreter, as far as a test looks at it.
IDLE = "import socket, sys; c = socket.socket(fileno=int(sys.argv[1])); c.send(b'ready'); c.recv(1)"
# A process that asks a mother for a zygote; it says so when that is warm, and lives on.
CLIENT = """
import os, sys, time
from pathlib import Path
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.zygote.client import Simulator

simulator = Simulator(WorkerSlot.from_json(sys.argv[1]), Path(sys.argv[2]))
assert simulator.wait_warm(900.0)
print("warm", flush=True)
time.sleep(600)
"""
# A worker of which only a process of its pool is left, which still has a run.
WORKER = """
import json, os, sys, time
from dataclasses import replace
from pathlib import Path
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.zygote.client import Mother, Simulator
from tests.worker.evaluation.fakes import FakeListener

slot, cache = WorkerSlot.from_json(sys.argv[1]), Path(sys.argv[2])
mother = Mother.start(slot, cache)
worker = os.getpid()
if os.fork():
    os.read(0, 1)
    os._exit(0)
simulator = Simulator(replace(slot, mother=mother.descriptor), cache)
assert simulator.wait_warm(900.0)
print(mother._process.pid, flush=True)
while os.getppid() == worker:
    time.sleep(0.01)
with simulator.begin(Job.from_json(sys.argv[3].encode())) as simulation:
    print(simulation.run(FakeListener(), lambda: None).digest, flush=True)
"""
# A worker with two cores, whose mother takes long.
HELPED = """
import os, time
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.proc_stats import tree
from seamark.worker.evaluation.cores import new_locks
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.zygote import mother

slot = WorkerSlot(IsolationLevel.NONE, 0, shared_cores=(0, 1, 2), core_locks=new_locks())
cores = slot.cores()
mother.LOADED_CPU_S = 0.0
with mother._helpers(slot):
    print(len(tree(os.getpid())) - 1)
    while not cores.parts()[0]:
        time.sleep(0.05)
print(len(tree(os.getpid())) - 1, cores.parts()[0])
"""


@pytest.fixture(scope="module")
def mother(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Mother]:
    """A mother of zygotes, as a worker has one."""
    started = Mother.start(ALONE, tmp_path_factory.mktemp("compiled"))
    yield started
    started.stop()


@pytest.fixture
def own_mother() -> Iterator[Mother]:
    """A mother that the test ends, which has loaded everything."""
    started = forked_workers.mother(ALONE)
    yield started
    started.stop()


def simulator_of(mother: Mother, folder: Path, program: str = "exit()") -> Simulator:
    """Return a simulator whose mother has to do it: a new interpreter would end at once."""
    slot = replace(ALONE, mother=mother.descriptor)
    return Simulator(slot, folder, program=("-c", program))


def zygotes_of(mother: Mother) -> list[int]:
    own = mother._process.pid
    return [pid for pid in tree(own) if parent_of(pid) == own]


def sockets_of(pid: int) -> list[str]:
    opened = [os.readlink(one) for one in Path(f"/proc/{pid}/fd").iterdir()]
    return [one for one in opened if one.startswith("socket:")]


def digest_of(simulator: Simulator) -> str | None:
    with simulator.begin(JOB) as simulation:
        return simulation.run(FakeListener(), lambda: None).digest


@pytest.mark.timeout(COMPILED_S + 60)
def test_zygotes_of_one_mother_cost_hardly_more_than_the_first(
    mother: Mother, tmp_path: Path
) -> None:
    first, *others = [simulator_of(mother, tmp_path) for _ in range(3)]
    assert first.wait_warm(COMPILED_S)
    before = cpu_s(tree(mother._process.pid))

    for other in others:
        assert other.wait_warm(FORKED_S)
    took_s = cpu_s(tree(mother._process.pid)) - before
    parents = [parent_of(pid) for pid in zygotes_of(mother)]
    for one in (first, *others):
        one.stop()

    assert took_s < 0.3  # a new interpreter takes a second for each
    assert parents == [mother._process.pid] * 3
    assert zygotes_of(mother) == []


@pytest.mark.timeout(COMPILED_S + 60)
def test_a_run_of_a_forked_zygote_has_the_digest_of_a_local_run(
    mother: Mother, tmp_path: Path
) -> None:
    wanted = evaluate_locally("currents-v1", SHORT, seed=3, trials=1, controller="p").digest
    one, two = simulator_of(mother, tmp_path), simulator_of(mother, tmp_path)
    assert one.wait_warm(COMPILED_S)

    found = [digest_of(one), digest_of(two), digest_of(one)]
    one.stop()
    two.stop()

    assert found == [wanted] * 3


@pytest.mark.timeout(COMPILED_S + 60)
def test_a_forked_zygote_has_no_descriptor_of_its_mother_or_of_another(
    mother: Mother, tmp_path: Path
) -> None:
    simulators = [simulator_of(mother, tmp_path) for _ in range(2)]
    for one in simulators:
        assert one.wait_warm(COMPILED_S)

    sockets = [sockets_of(pid) for pid in zygotes_of(mother)]
    running = threads([mother._process.pid])
    for one in simulators:
        one.stop()

    assert [len(found) for found in sockets] == [1, 1]  # the one on which its jobs come
    assert len({*map(tuple, sockets)}) == 2
    assert len(running) == 1  # a fork would keep the locks of others


@pytest.mark.timeout(COMPILED_S + 60)
def test_a_forked_zygote_that_is_killed_is_noticed_and_another_takes_its_place(
    mother: Mother, tmp_path: Path
) -> None:
    simulator = simulator_of(mother, tmp_path)
    assert simulator.wait_warm(COMPILED_S)
    [killed] = zygotes_of(mother)

    os.kill(killed, signal.SIGSTOP)  # so that the job waits
    with simulator.begin(JOB) as simulation:
        os.kill(killed, signal.SIGKILL)
        with pytest.raises(SimulatorBroken):
            simulation.run(FakeListener(), lambda: None)
    eventually(lambda: not zygotes_of(mother))
    again = simulator.wait_warm(FORKED_S)
    [another] = zygotes_of(mother)
    simulator.stop()

    assert again
    assert another != killed


@pytest.mark.timeout(COMPILED_S + 60)
def test_a_forked_zygote_ends_with_the_process_that_asked_for_it(
    mother: Mother, tmp_path: Path
) -> None:
    slot = replace(ALONE, mother=mother.descriptor).to_json()
    asking = subprocess.Popen(
        [sys.executable, "-c", CLIENT, slot, tmp_path],
        stdout=subprocess.PIPE,
        pass_fds=[mother.descriptor],
    )
    assert asking.stdout is not None
    with asking.stdout:
        said = asking.stdout.readline()
    [zygote] = zygotes_of(mother)
    os.kill(zygote, signal.SIGSTOP)  # so that it cannot end by itself

    asking.kill()
    asking.wait()

    assert said == b"warm\n"
    eventually(lambda: not zygotes_of(mother))


@pytest.mark.timeout(COMPILED_S + 60)
def test_a_signal_to_the_group_leaves_the_mother_alone(mother: Mother, tmp_path: Path) -> None:
    simulator = simulator_of(mother, tmp_path)
    assert simulator.wait_warm(COMPILED_S)

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        os.kill(mother._process.pid, number)
    simulator.stop()
    warm = simulator.wait_warm(FORKED_S)
    [zygote] = zygotes_of(mother)
    os.kill(zygote, signal.SIGTERM)
    eventually(lambda: not zygotes_of(mother))
    simulator.stop()

    assert warm


@pytest.mark.timeout(COMPILED_S + 60)
def test_a_zygote_of_a_mother_that_is_killed_is_a_new_interpreter(
    own_mother: Mother, tmp_path: Path
) -> None:
    simulator = simulator_of(own_mother, tmp_path, IDLE)
    assert simulator.wait_warm(COMPILED_S)
    [zygote] = zygotes_of(own_mother)

    own_mother._process.kill()
    eventually(lambda: not command_line(zygote))
    simulator.start()
    warm = simulator.wait_warm(FORKED_S)
    new = [pid for pid in children() if IDLE.encode() in command_line(pid)]
    simulator.stop()

    assert warm
    assert len(new) == 1


def test_a_mother_that_hangs_is_done_without(
    own_mother: Mother, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    os.kill(own_mother._process.pid, signal.SIGSTOP)
    simulator = simulator_of(own_mother, tmp_path, IDLE)
    assert not simulator.wait_warm(0.1)

    monkeypatch.setattr(client, "MOTHER_MAX_S", 0.0)
    warm = simulator.wait_warm(FORKED_S)
    simulator.stop()

    assert warm


@pytest.mark.timeout(COMPILED_S + 60)
def test_a_zygote_that_nobody_waited_for_is_kept(
    mother: Mother, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    simulator = simulator_of(mother, tmp_path)
    first = digest_of(simulator)
    before = zygotes_of(mother)

    monkeypatch.setattr(client, "MOTHER_MAX_S", 0.0)
    again = digest_of(simulator)
    after = zygotes_of(mother)
    simulator.stop()

    assert first == again
    assert after == before
    assert len(after) == 1


@pytest.mark.timeout(COMPILED_S + 60)
def test_a_process_that_outlives_its_worker_still_ends_its_run_and_then_the_mother_ends(
    tmp_path: Path,
) -> None:
    wanted = evaluate_locally("currents-v1", SHORT, seed=3, trials=1, controller="p").digest
    worker = subprocess.Popen(
        [sys.executable, "-c", WORKER, ALONE.to_json(), tmp_path, JOB.to_json()],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert worker.stdout is not None
    with worker.stdout:
        mother = int(worker.stdout.readline())
        worker.kill()
        worker.wait()
        digest = worker.stdout.readline().strip()

    assert digest == wanted
    assert eventually(lambda: not command_line(mother))
    assert worker.stdin is not None
    worker.stdin.close()


@pytest.mark.timeout(COMPILED_S + 60)
def test_the_other_cores_of_a_worker_help_a_mother_that_takes_long_and_leave_nothing() -> None:
    assert printed(HELPED).split() == ["2", "0", "0"]
