"""Resources leaked by many runs of programs that try to survive their box: should be none.

Each run takes a box from the pool, starts a program that forks and prints, and does some steps.
This is not about speed, but it takes too long for the tests, which do fifty runs.
"""

import contextlib
import os
import select
import threading
import time
from pathlib import Path

from performance.tables import Row
from seamark.sandbox.box import Box
from seamark.sandbox.isolation import cgroup_parents
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, SandboxBroken
from seamark.sandbox.pool import Pool
from seamark.sandbox.probing.probes import probe

RUNS = 1000
WARM_UP_RUNS = 20  # before the first count: what is created only once is no leak
EXIT_TIMEOUT_S = 1.0
STAYS = b"""
import os, time

class Controller:
    def __init__(self, config):
        if os.fork() == 0:
            os.setsid()
            if os.fork() == 0:
                time.sleep(600)
            os._exit(0)

    def step(self, observation):
        print("x" * 1000)
        return [0.0, 0.0, 0.0, 0.0]
"""
LAYOUT = {"observation": [["t", 0]]}


def rows() -> list[Row]:
    """Run, and return how much of each resource was leaked."""
    isolation = probe().level
    with Pool({"python": 1}, limits=Limits(), isolation=isolation) as pool:
        _run(pool, WARM_UP_RUNS)
        before = _resources()
        begin = time.perf_counter()
        survivors = _run(pool, RUNS)
        took_s = time.perf_counter() - begin
        after = _resources()
    title = f"leaked after {RUNS} runs, isolation {isolation.name.lower()}"
    leaked = {"processes": survivors} | {name: after[name] - before[name] for name in after}
    return [
        *(
            Row(what=f"{name} {title}", value=float(count), unit="")
            for name, count in leaked.items()
        ),
        Row(what="one run, including the start of its box", value=took_s / RUNS * 1e3, unit="ms"),
    ]


def _run(pool: Pool, runs: int) -> int:
    """Return how many processes survived the end of their box."""
    survivors = 0
    for _ in range(runs):
        pool.refill()
        with contextlib.ExitStack() as watching:
            with pool.take("python", Limits()) as box, contextlib.suppress(ProgramEnded):
                watched = _used(box, watching)
            # A process leaves its cgroup slightly before its exit is reported.
            survivors += sum(not select.select([one], [], [], EXIT_TIMEOUT_S)[0] for one in watched)
    return survivors


def _used(box: Box, watching: contextlib.ExitStack) -> list[int]:
    """Run a program to its end; return pidfds of all processes of its box."""
    box.load(STAYS, "stays.py", {}, LAYOUT)
    watched = []
    for pid in box.processes():
        with contextlib.suppress(ProcessLookupError):
            watched.append(os.pidfd_open(pid))
            watching.callback(os.close, watched[-1])
    for step in range(3):
        box.step([step / 20])
    box.finish()
    return watched


def _resources() -> dict[str, int]:
    """Return the amount of each resource that this process holds."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    memory_kib = int(status.split("VmRSS:")[1].split()[0])
    groups = [group for folder in _groups() for group in folder.glob(f"*-box-{os.getpid()}-*")]
    return {
        "control groups": len(groups),
        "descriptors": len(os.listdir("/proc/self/fd")),
        "threads": threading.active_count(),
        "KiB of memory": memory_kib,
    }


def _groups() -> list[Path]:
    try:
        return cgroup_parents.parent_groups().folders()
    except SandboxBroken:  # no cgroups on this host
        return []
