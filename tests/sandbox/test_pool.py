"""Boxes that wait: used once, replaced when old or dead, and none left at the end."""

import os
import select
import signal
from dataclasses import replace

import pytest

from sandbox.box import Box
from sandbox.level import Level
from sandbox.limits import Limits
from sandbox.outcome import ProgramEnded, Verdict
from sandbox.pool import Pool

pytestmark = pytest.mark.host

LIMITS = Limits(cpu_s=60.0)
LAYOUT = {"observation": [["t", 0]], "command": []}
SOURCE = b"""
class Controller:
    def __init__(self, config): ...
    def step(self, observation):
        while observation.t > 0.0: pass
        return [1.0, 2.0, 3.0, 4.0]
"""


def pool(level: Level, stock: int = 1, oldest_s: float = 600.0) -> Pool:
    return Pool({"python": stock}, limits=LIMITS, level=level, oldest_s=oldest_s)


def answer(box: Box, t: float = 0.0) -> tuple[float, ...]:
    box.load(SOURCE, "a.py", {}, LAYOUT)
    return box.step([t])


def pid_of(box: Box) -> int:
    box.wait_ready()
    return box.processes()[0]


def test_a_box_in_stock_answers_like_a_new_one_and_is_used_once(level) -> None:
    with pool(level) as boxes:
        boxes.refill()
        with boxes.take("python", LIMITS) as warm, boxes.take("python", LIMITS) as new:
            assert answer(warm) == answer(new) == (1.0, 2.0, 3.0, 4.0)
            assert pid_of(warm) != pid_of(new)


def test_refilling_keeps_what_is_there_and_adds_what_is_missing(level) -> None:
    with pool(level, stock=2) as boxes:
        boxes.refill()
        boxes.take("python", LIMITS).close()
        assert boxes.waiting() == 1
        boxes.refill()
        assert boxes.waiting() == 2


def test_a_box_that_waited_too_long_is_replaced(level) -> None:
    with pool(level, oldest_s=0.0) as boxes:
        boxes.refill()
        before = len(os.listdir("/proc/self/fd"))
        boxes.refill()

        assert boxes.waiting() == 1
        assert len(os.listdir("/proc/self/fd")) == before


def test_a_box_that_died_while_it_waited_is_replaced_by_a_new_one(level) -> None:
    with pool(level, stock=1) as boxes:
        boxes.refill()
        box = boxes._waiting["python"][0].box
        os.kill(pid_of(box), signal.SIGKILL)
        assert select.select([box._cage.pidfd], [], [], 5.0)[0]

        with boxes.take("python", LIMITS) as other:
            assert answer(other) == (1.0, 2.0, 3.0, 4.0)


def test_a_box_in_stock_gets_the_times_of_its_run(level) -> None:
    limits = replace(LIMITS, cpu_s=30.0, step_cpu_s=0.3)
    with pool(level) as boxes:
        boxes.refill()
        with boxes.take("python", limits) as box:
            assert boxes.waiting() == 0
            with pytest.raises(ProgramEnded, match=r"0\.3 s of CPU time") as end:
                answer(box, t=1.0)

    assert end.value.outcome.verdict is Verdict.TIME_LIMIT


@pytest.mark.parametrize("other", [{"memory_mib": 256}, {"processes": 8}, {"cpu_s": 61.0}])
def test_what_the_kernel_holds_cannot_be_changed_so_that_a_new_box_is_made(level, other) -> None:
    with pool(level) as boxes:
        boxes.refill()
        boxes.take("python", replace(LIMITS, **other)).close()
        assert boxes.waiting() == 1


def test_a_box_takes_no_limits_that_do_not_fit_it(level) -> None:
    with Box(limits=LIMITS, level=level) as box, pytest.raises(ValueError, match="do not fit"):
        box.adopt(replace(LIMITS, memory_mib=1024))


def test_no_box_is_left_when_the_pool_closes(level) -> None:
    before = len(os.listdir("/proc/self/fd"))
    with pool(level, stock=2) as boxes:
        boxes.refill()
        waiting = [one.box for one in boxes._waiting["python"]]
        for box in waiting:
            box.wait_ready()
        everybody = [os.pidfd_open(pid) for box in waiting for pid in box.processes()]

    assert len(everybody) >= 4
    for descriptor in everybody:
        assert select.select([descriptor], [], [], 5.0)[0]
        os.close(descriptor)
    assert len(os.listdir("/proc/self/fd")) == before
