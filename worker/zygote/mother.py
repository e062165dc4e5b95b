"""The mother of a worker's zygotes: it loads the simulator once, and forks them when it has.

Started by itself, each zygote would spend a second of CPU time on loading what the others have
loaded already, and have it in memory once more. The mother has one thread, no box and no job: it
lives as long as anybody can ask it for a zygote.
"""

import gc
import os
import signal
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from seamark.sandbox.isolation import proc_stats
from seamark.sim.engine.warm_up import warm_up
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.ipc.fork_server import DEFERRED, ForkServer, say_nothing
from seamark.worker.ipc.process_control import die_with_parent, outlive_parent, run_forked, show_as
from seamark.worker.zygote.process import Zygote

# [s] of CPU time in which the mother has loaded what was compiled before, on slow machines too
LOADED_CPU_S = 5.0
POLL_S = 0.5  # [s] between two looks at whether it takes longer


def main(arguments: list[str]) -> None:
    """Be the mother: of the descriptor of requests, the first slot and the worker's process."""
    descriptor, slot_json, parent = arguments
    # A signal to the whole group means the others; this process ends when nobody needs it.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, DEFERRED)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # as the processes of the pool have it
    die_with_parent(int(parent))
    gc.freeze()
    gc.enable()  # disabled by who starts it; compiling leaves garbage
    slot = WorkerSlot.from_json(slot_json)
    with _helpers(slot):
        warm_up(slot.cores().announce_part)
    # A process of the pool that outlives its worker may still end its run.
    outlive_parent()
    gc.freeze()  # forks share what is loaded as long as nobody touches it
    with socket.socket(fileno=int(descriptor)) as control:
        ForkServer(control, _begin, mask=mask).serve()


@contextmanager
def _helpers(slot: WorkerSlot) -> Iterator[None]:
    """Have a process on each other core of the worker compile, where nothing is compiled yet."""
    parent, pids = os.getpid(), []
    for _ in slot.shared_cores[1:]:
        pid = os.fork()
        if pid == 0:
            run_forked(partial(_help, slot, parent), say_nothing)
        pids.append(pid)
    try:
        yield
    finally:
        for pid in pids:
            os.kill(pid, signal.SIGKILL)
            os.waitpid(pid, 0)


def _help(slot: WorkerSlot, parent: int) -> None:
    """Take parts of the mother's work if it compiles; the parts are announced until it is done."""
    die_with_parent(parent)
    while proc_stats.cpu_s([parent]) < LOADED_CPU_S:
        time.sleep(POLL_S)
    warm_up(slot.cores().announce_part)
    signal.pause()


def _begin(request: bytes, descriptors: list[int]) -> Callable[[], None]:
    """Return how a fork becomes the zygote of a slot that takes jobs on a socket."""
    return partial(_be_zygote, WorkerSlot.from_json(request.decode()), *descriptors)


def _be_zygote(slot: WorkerSlot, descriptor: int) -> None:
    show_as(["seamark.worker.zygote.process", f"core={slot.core}"])
    with socket.socket(fileno=descriptor) as control:
        Zygote(control, slot).serve()
