"""What is left after many runs of programs that try to stay: it should be nothing.

Each run is a box from the pool, a program that forks and prints, some steps, an end. No matter of
speed, but it takes too long for the tests, which do fifty.
"""

import contextlib
import os
import select
import threading
import time
from pathlib import Path

from performance.table import Row
from seamark.sandbox.box import Box
from seamark.sandbox.isolation import cgroups
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, SandboxBroken
from seamark.sandbox.pool import Pool
from seamark.sandbox.probing.probes import probe

RUNS = 1000
FIRST = 20  # runs before the first look: what is made once is no leftover
TELL_S = 1.0  # [s]
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
LAYOUT = {"observation": [["t", 0]], "command": []}


def rows() -> list[Row]:
    """Run, and return what there is more of than before."""
    isolation = probe().level
    with Pool({"python": 1}, limits=Limits(), isolation=isolation) as pool:
        _run(pool, FIRST)
        before = _held()
        begin = time.perf_counter()
        survivors = _run(pool, RUNS)
        took_s = time.perf_counter() - begin
        after = _held()
    title = f"left after {RUNS} runs, level {isolation.name.lower()}"
    left = {"processes": survivors} | {name: after[name] - before[name] for name in after}
    return [
        *(Row(what=f"{name} {title}", value=float(count), unit="") for name, count in left.items()),
        Row(what="one run, the start of its box included", value=took_s / RUNS * 1e3, unit="ms"),
    ]


def _run(pool: Pool, runs: int) -> int:
    """Return how many processes lived on after the end of their box."""
    survivors = 0
    for _ in range(runs):
        pool.refill()
        with contextlib.ExitStack() as watching:
            with pool.take("python", Limits()) as box, contextlib.suppress(ProgramEnded):
                watched = _used(box, watching)
            # The kernel takes a process out of its group a moment before it tells of its end.
            survivors += sum(not select.select([one], [], [], TELL_S)[0] for one in watched)
    return survivors


def _used(box: Box, watching: contextlib.ExitStack) -> list[int]:
    """Let a program run to its end; return descriptors of all processes that it had."""
    box.load(STAYS, "stays.py", {}, LAYOUT)
    watched = []
    for pid in box.processes():
        with contextlib.suppress(ProcessLookupError):
            watched.append(os.pidfd_open(pid))
            watching.callback(os.close, watched[-1])
    for tick in range(3):
        box.step([tick / 20])
    box.finish()
    return watched


def _held() -> dict[str, int]:
    """Return how much of everything this process holds."""
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
        return cgroups.places().folders()
    except SandboxBroken:  # this host has none
        return []
