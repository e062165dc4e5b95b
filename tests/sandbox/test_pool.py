"""Pre-started boxes: used once, replaced when old or dead, and none left at the end."""

import os
import select
import signal
from dataclasses import replace

import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, Verdict
from seamark.sandbox.pool import BoxLease, Pool
from tests.sandbox.conftest import count_of_descriptors

pytestmark = pytest.mark.host

LIMITS = Limits(cpu_s=60.0)
LAYOUT = {"observation": [["t", 0]]}
SOURCE = b"""
class Controller:
    def __init__(self, config): ...
    def step(self, observation):
        while observation.t > 0.0: pass
        return [1.0, 2.0, 3.0, 4.0]
"""


def idle(boxes: Pool) -> int:
    return sum(map(len, boxes._idle.values()))


def pool(isolation: IsolationLevel, stock: int = 1, max_age_s: float = 600.0) -> Pool:
    return Pool({"python": stock}, limits=LIMITS, isolation=isolation, max_age_s=max_age_s)


def answer(box: Box, t: float = 0.0) -> tuple[float, ...]:
    box.load(SOURCE, "a.py", {}, LAYOUT)
    return box.step([t])


def pid_of(box: Box) -> int:
    box.wait_ready()
    return box.processes()[0]


def test_a_box_in_stock_answers_like_a_new_one_and_is_used_once(isolation) -> None:
    with pool(isolation) as boxes:
        boxes.refill()
        with boxes.take("python", LIMITS) as warm, boxes.take("python", LIMITS) as new:
            assert answer(warm) == answer(new) == (1.0, 2.0, 3.0, 4.0)
            assert pid_of(warm) != pid_of(new)


def test_refilling_keeps_idle_boxes_and_adds_the_missing_ones(isolation) -> None:
    with pool(isolation, stock=2) as boxes:
        boxes.refill()
        boxes.take("python", LIMITS).close()
        assert idle(boxes) == 1
        boxes.refill()
        assert idle(boxes) == 2


def test_a_box_that_waited_too_long_is_replaced(isolation) -> None:
    with pool(isolation, max_age_s=0.0) as boxes:
        boxes.refill()
        before = count_of_descriptors()
        boxes.refill()

        assert idle(boxes) == 1
        assert count_of_descriptors() == before


def test_a_box_that_died_while_it_waited_is_replaced_by_a_new_one(isolation) -> None:
    with pool(isolation, stock=1) as boxes:
        boxes.refill()
        box = boxes._idle["python"][0].box
        os.kill(pid_of(box), signal.SIGKILL)
        assert select.select([box._tree.pidfd], [], [], 5.0)[0]

        with boxes.take("python", LIMITS) as other:
            assert answer(other) == (1.0, 2.0, 3.0, 4.0)


def test_a_box_in_stock_gets_the_time_limits_of_its_run(isolation) -> None:
    limits = replace(LIMITS, cpu_s=30.0, step_cpu_s=0.3)
    with pool(isolation) as boxes:
        boxes.refill()
        with boxes.take("python", limits) as box:
            assert idle(boxes) == 0
            with pytest.raises(ProgramEnded, match=r"0\.3 s of CPU time") as end:
                answer(box, t=1.0)

    assert end.value.outcome.verdict is Verdict.TIME_LIMIT


@pytest.mark.parametrize("other", [{"memory_mib": 256}, {"processes": 8}, {"cpu_s": 61.0}])
def test_limits_enforced_by_the_kernel_cannot_change_so_a_new_box_is_started(
    isolation, other
) -> None:
    with pool(isolation) as boxes:
        boxes.refill()
        boxes.take("python", replace(LIMITS, **other)).close()
        assert idle(boxes) == 1


def test_a_box_refuses_limits_that_do_not_fit_it(isolation) -> None:
    with (
        Box(limits=LIMITS, isolation=isolation) as box,
        pytest.raises(ValueError, match="do not fit"),
    ):
        box.assign(replace(LIMITS, memory_mib=1024), "python")


def test_a_box_refuses_a_language_with_another_runtime(isolation) -> None:
    with (
        Box(limits=LIMITS, isolation=isolation) as box,
        pytest.raises(ValueError, match="does not run"),
    ):
        box.assign(LIMITS, "matlab")


def test_compiled_languages_share_a_stock(isolation) -> None:
    with Pool({"c": 1, "c++": 1}, limits=LIMITS, isolation=isolation) as boxes:
        boxes.refill()
        assert idle(boxes) == 1
        boxes.take("executable", LIMITS).close()
        assert idle(boxes) == 0


def in_a_fork(lease: BoxLease, boxes: Pool, kill: bool = False) -> bytes:
    """Let a fork use its leased boxes; return its report, empty if it was killed."""
    reading, writing = os.pipe()
    pid = os.fork()
    if pid == 0:
        lease.take_over()
        box = boxes.take("python", LIMITS)
        says = f"{answer(box)[2]} {idle(boxes)}"
        if kill:
            os.kill(os.getpid(), signal.SIGKILL)
        says += f" {box.finish().verdict}"
        box.close()
        os.write(writing, says.encode())
        os._exit(0)
    lease.hand_over()
    os.close(writing)
    with os.fdopen(reading, "rb") as said:
        text = said.read()
    os.waitpid(pid, 0)
    return text


def test_a_fork_uses_the_box_that_it_is_leased_and_no_other(isolation) -> None:
    with pool(isolation, stock=2) as boxes:
        boxes.refill()
        mine = boxes._idle["python"][1].box
        lease = boxes.lease("python", 1)
        lent = os.pidfd_open(pid_of(lease._leased[0].box))

        assert in_a_fork(lease, boxes) == b"3.0 0 ok"

        lease.close()
        assert select.select([lent], [], [], 5.0)[0]
        os.close(lent)
        assert answer(mine) == (1.0, 2.0, 3.0, 4.0)


def test_the_box_of_a_fork_that_was_killed_ends_with_the_lease(isolation) -> None:
    before = count_of_descriptors()
    with pool(isolation) as boxes:
        boxes.refill()
        lease = boxes.lease("python", 1)
        pidfds = [os.pidfd_open(pid) for pid in lease._leased[0].box.processes()]

        assert in_a_fork(lease, boxes, kill=True) == b""

        lease.close()
        assert pidfds
        for one in pidfds:
            assert select.select([one], [], [], 5.0)[0]
            os.close(one)
    assert count_of_descriptors() == before


def test_a_box_moves_to_the_cores_of_the_process_that_takes_it(isolation) -> None:
    cores = os.sched_getaffinity(0)
    first, last = min(cores), max(cores)
    with Pool({"python": 1}, limits=LIMITS, isolation=isolation, core=first) as boxes:
        boxes.refill()
        os.sched_setaffinity(0, {last})
        try:
            with boxes.take("python", LIMITS) as box:
                assert {frozenset(os.sched_getaffinity(pid)) for pid in box.processes()} == {
                    frozenset({last})
                }
        finally:
            os.sched_setaffinity(0, cores)


def test_no_box_is_left_when_the_pool_closes(isolation) -> None:
    before = count_of_descriptors()
    with pool(isolation, stock=2) as boxes:
        boxes.refill()
        waiting = [one.box for one in boxes._idle["python"]]
        for box in waiting:
            box.wait_ready()
        everybody = [os.pidfd_open(pid) for box in waiting for pid in box.processes()]

    assert len(everybody) >= 4
    for descriptor in everybody:
        assert select.select([descriptor], [], [], 5.0)[0]
        os.close(descriptor)
    assert count_of_descriptors() == before
