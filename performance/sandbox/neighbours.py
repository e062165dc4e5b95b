"""The CPU time that a program gets beside boxes with many processes on its core.

Three boxes share the core equally if each gets a third, whatever the number of its processes.
"""

import contextlib
import os
import time
from collections.abc import Iterator

from performance.tables import Row
from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits
from seamark.sandbox.probing.probes import probe
from seamark.sandbox.probing.self_test import LAYOUT

NEIGHBOURS = 2  # boxes
SPINNERS = 14  # processes in each
LIMITS = Limits(start_cpu_s=60.0)
SPINS = f"""\
import os

class Controller:
    def __init__(self, config):
        for _ in range({SPINNERS}):
            if os.fork() == 0:
                while True:
                    pass

    def step(self, observation): ...
"""
COMPUTES = """\
import time

class Controller:
    def __init__(self, config):
        while time.process_time() < 1.0:
            pass

    def step(self, observation): ...
"""


def rows() -> list[Row]:
    """Measure at the isolation level of this host, and below it."""
    best = probe().level
    return [
        _row(level) for level in (IsolationLevel.MEDIUM, IsolationLevel.STRONG) if level <= best
    ]


def _row(isolation: IsolationLevel) -> Row:
    core = max(os.sched_getaffinity(0))
    alone = _share(isolation, core)
    with _neighbours(isolation, core):
        beside = _share(isolation, core)
    return Row(
        what=f"CPU time beside {NEIGHBOURS} boxes of {SPINNERS} processes, "
        f"isolation {isolation.name.lower()}",
        value=100 * beside,
        unit="% of a core",
        baseline="without them",
        baseline_value=100 * alone,
    )


@contextlib.contextmanager
def _neighbours(isolation: IsolationLevel, core: int) -> Iterator[None]:
    with contextlib.ExitStack() as boxes:
        started = [
            boxes.enter_context(Box(limits=LIMITS, isolation=isolation, core=core))
            for _ in range(NEIGHBOURS)
        ]
        for box in started:
            box.wait_ready()
        for box in started:
            box.load(SPINS.encode(), "spins.py", {}, LAYOUT)
        yield


def _share(isolation: IsolationLevel, core: int) -> float:
    """Return the CPU time per wall time of a program that always computes."""
    with Box(limits=LIMITS, isolation=isolation, core=core) as box:
        box.wait_ready()
        cpu_s, begin = box.usage().cpu_s, time.monotonic()
        box.load(COMPUTES.encode(), "computes.py", {}, LAYOUT)
        return (box.usage().cpu_s - cpu_s) / (time.monotonic() - begin)
