"""The wall limits of a program do not count the time in which the host runs others."""

import os
import signal
import subprocess
import sys
from dataclasses import dataclass, field
from typing import cast

import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.process_tree import ProcessTree
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, SandboxBroken, Verdict
from seamark.sandbox.protocol import session
from seamark.sandbox.protocol.starvation import Starvation
from tests.sandbox.conftest import LAYOUT, VALUES, program

CORE = min(os.sched_getaffinity(0))
SPINNERS = f"""
import os, signal
os.sched_setaffinity(0, {{{CORE}}})
for _ in range(8):
    if (pid := os.fork()) == 0:
        os.setsid()  # for a share of its own
        signal.alarm(60)
        while True: pass
    print(pid, flush=True)
"""
COMPUTES = b"""
import time

class Controller:
    def __init__(self, config):
        pass

    def step(self, observation):
        begin_s = time.process_time()  # whatever its start took
        while time.process_time() - begin_s < 0.08:
            pass
        return [0.0, 0.0, 0.0, 0.0]
"""


@dataclass
class Tree:
    """The readings that a test chooses."""

    used_s: float = 0.0
    waits_s: dict[int, float] = field(default_factory=dict)

    def cpu_s(self) -> float:
        return self.used_s

    def run_queue_waits_s(self) -> dict[int, float]:
        return self.waits_s


def starved_s(before: Tree, after: Tree) -> float:
    tree = Tree(before.used_s, before.waits_s)
    starvation = Starvation(cast(ProcessTree, tree))
    tree.used_s, tree.waits_s = after.used_s, after.waits_s
    return starvation.so_far_s()


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        (Tree(1.0, {7: 3.0}), Tree(1.5, {7: 9.0}), 5.5),  # it waited 6 s, and ran half a second
        (Tree(1.0, {7: 3.0}), Tree(1.0, {7: 3.0}), 0.0),  # it slept
        (Tree(0.0, {7: 0.0}), Tree(9.0, {7: 8.0, 8: 9.0, 9: 9.0}), 0.0),  # it waited for itself
        (Tree(0.0, {7: 0.0}), Tree(1.0, {7: 0.0, 8: 6.0}), 5.0),  # a new thread had to wait
        (Tree(0.0, {7: 5.0}), Tree(1.0, {}), 0.0),  # its thread has ended
    ],
)
def test_the_host_is_to_blame_for_waiting_that_exceeds_what_the_box_ran(
    before, after, expected
) -> None:
    assert starved_s(before, after) == expected


def stepped_on_a_busy_core(
    source: bytes, isolation: IsolationLevel, *, step_wall_s: float
) -> object:
    """Return the answer to one step, while eight others want the same core."""
    with Box(limits=Limits(step_wall_s=step_wall_s), isolation=isolation, core=CORE) as box:
        box.load(source, "a.py", {}, LAYOUT)
        with subprocess.Popen([sys.executable, "-c", SPINNERS], stdout=subprocess.PIPE) as others:
            assert others.stdout is not None
            pids = [int(others.stdout.readline()) for _ in range(8)]
            try:
                return box.step(VALUES)
            finally:
                for pid in pids:
                    os.kill(pid, signal.SIGKILL)


@pytest.fixture(params=[IsolationLevel.MEDIUM, IsolationLevel.STRONG], ids=["medium", "strong"])
def level(request, isolation: IsolationLevel) -> IsolationLevel:
    if request.param > isolation:
        pytest.skip("this host does not reach this level")
    found: IsolationLevel = request.param
    return found


@pytest.mark.host
def test_a_program_that_the_host_hardly_runs_is_not_blamed_for_it(level, monkeypatch) -> None:
    monkeypatch.setattr(session, "MAX_STEP_WALL_S", 60.0)  # others may want the core as well

    assert stepped_on_a_busy_core(COMPUTES, level, step_wall_s=0.5) == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.host
def test_a_program_that_sleeps_is_blamed_on_a_busy_host_too(isolation) -> None:
    sleeps = program(step="import time; time.sleep(60)")

    with pytest.raises(ProgramEnded) as end:
        stepped_on_a_busy_core(sleeps, isolation, step_wall_s=0.5)

    assert end.value.outcome.verdict is Verdict.TIME_LIMIT
    assert "did not return within 0.5 s" in end.value.outcome.sentence


@pytest.mark.host
def test_a_program_that_the_host_runs_far_too_little_is_our_failure(isolation, monkeypatch) -> None:
    monkeypatch.setattr(session, "MAX_STEP_WALL_S", 0.4)

    with pytest.raises(SandboxBroken, match="hardly ran"):
        stepped_on_a_busy_core(COMPUTES, isolation, step_wall_s=0.5)
