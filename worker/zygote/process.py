"""The simulator zygote: one warm process per Celery child, which forks a child for each run.

It loads the simulator and its compiled code once. A job comes as one packet on the descriptor,
together with the socket for the messages of the child. Boxes of each language are started between
runs and wait here, so that a run begins in milliseconds. Nothing of a run survives in the zygote:
the child that ran it ends, and its boxes with it.
"""

import contextlib
import gc
import os
import select
import signal
import socket
from typing import NamedTuple

from seamark.programs import parameters
from seamark.sandbox.isolation.cgroups import remove_orphans
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.pool import BoxLease, Pool
from seamark.sim import registry
from seamark.sim.engine.warm_up import warm_up
from seamark.sim.settings import own_files
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.vehicles import own
from seamark.worker.evaluation.bridged import evaluate_bridged
from seamark.worker.evaluation.check import check
from seamark.worker.evaluation.evaluation import Evaluation
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.parallel_trials import first_language
from seamark.worker.evaluation.program_adapters import box_pool, sandboxed_compiler
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.ipc import messages
from seamark.worker.ipc.listener import Sender
from seamark.worker.ipc.messages import BoxFailed, Crashed, RunEnded, Started
from seamark.worker.ipc.outcomes import RunOutcome, no_longer_valid
from seamark.worker.ipc.process_control import die_with_parent, limit_simulator, pin, run_forked

READY = b"ready"  # sent once on the control socket when everything is loaded and compiled
JOB_MAX = 128 * 1024  # [byte]
CPU_LIMIT_S = 4 * 3600  # [s] of one simulator child
REFILL_S = 30.0  # [s] between two checks of the age of warm boxes


class Zygote:
    """Forks a child for each job; owns the warm boxes and leases them to the children."""

    def __init__(self, control: socket.socket, slot: WorkerSlot) -> None:
        self._control = control
        self._slot = slot
        self._pool = box_pool(slot)
        self._children: dict[int, Child] = {}  # by pidfd

    def serve(self) -> None:
        """Take jobs until the Celery child ends, or wants this process to; leave no box."""
        self._control.send(READY)
        self._slot.cores().announce_warm()
        try:
            with self._pool:
                self._take_jobs()
        finally:
            self._end_children()
            if self._slot.isolation is IsolationLevel.STRONG:
                remove_orphans()  # of the children: a box of their own dies with them

    def _take_jobs(self) -> None:
        control = self._control.fileno()
        while True:
            if not self._children:
                self._pool.refill()  # nobody is waiting now, and the core is free
            ready, _, _ = select.select([control, *self._children], [], [], REFILL_S)
            for descriptor in ready:
                if descriptor != control:
                    self._reap(descriptor)
                elif not self._take_job():
                    return

    def _end_children(self) -> None:
        for pidfd in [*self._children]:
            with contextlib.suppress(ProcessLookupError):
                signal.pidfd_send_signal(pidfd, signal.SIGKILL)
            self._reap(pidfd)

    def _take_job(self) -> bool:
        packet, descriptors, _, _ = socket.recv_fds(self._control, JOB_MAX, 1)
        if not packet:
            return False
        job, parent = Job.from_json(packet), os.getpid()
        boxes = self._lease(job)
        with socket.socket(fileno=descriptors[0]) as channel:
            pid = os.fork()
            if pid == 0:
                self._control.close()
                run_forked(
                    lambda: _run(job, channel, self._slot, self._pool, boxes, parent),
                    lambda text: messages.send(channel, Crashed(text)),
                )
        boxes.hand_over()
        self._children[os.pidfd_open(pid)] = Child(pid, boxes)
        return True

    def _lease(self, job: Job) -> BoxLease:
        """Reserve the boxes that wait for the programs of a job."""
        if not job.languages:
            return self._pool.lease(job.language, 0)
        language, per_trial = first_language(job.languages)
        return self._pool.lease(language, per_trial * len(job.seeds))

    def _reap(self, pidfd: int) -> None:
        """Reap a child that ended, and close the boxes that it could not close."""
        child = self._children.pop(pidfd)
        os.close(pidfd)
        os.waitpid(child.pid, 0)
        child.boxes.close()


class Child(NamedTuple):
    """A process that evaluates a job, and the boxes that are leased to it."""

    pid: int
    boxes: BoxLease


def _run(
    job: Job, channel: socket.socket, slot: WorkerSlot, pool: Pool, boxes: BoxLease, parent: int
) -> None:
    """Evaluate a job as a simulator child; the outcome is the last message."""
    boxes.take_over()
    die_with_parent(parent)
    limit_simulator(CPU_LIMIT_S)
    pin(slot.core)
    messages.send(channel, Started(os.getpid()))
    slot.cores().occupy()
    try:
        with pool:
            outcome = _evaluate(job, Sender(channel), slot, pool)
    except SandboxBroken as broken:
        messages.send(channel, BoxFailed(str(broken)))
    else:
        messages.send(channel, RunEnded(outcome))


def _evaluate(job: Job, sender: Sender, slot: WorkerSlot, pool: Pool) -> RunOutcome:
    vehicle = {} if job.vehicle is None else {own.SETTING: job.vehicle}
    if files := vehicle | dict(job.files):
        # A stranger's: they are known to this process alone, which ends with the run.
        try:
            for setting, path in files.items():
                own_files.add(setting, path.read_bytes())
            registry.benchmark(job.benchmark).read(parameters.split(job.config)[0])
        except (*own_files.INVALID, ConfigurationInvalid) as invalid:
            return no_longer_valid(invalid)
    compile_program = sandboxed_compiler(slot)
    if job.check:
        return check(job, sender, pool.take, compile_program)
    if job.bridge is not None:
        return evaluate_bridged(job, sender, pool.take)
    cores = slot.cores_for(len(job.seeds))
    return Evaluation(
        job, sender, pool.take, compile_program=compile_program, cores=cores, pool=pool
    ).run()


def main(arguments: list[str]) -> None:
    """Be the zygote: of a control socket's descriptor, a slot and the process of the client."""
    descriptor, slot_json, parent = arguments
    die_with_parent(int(parent))
    gc.freeze()  # modules stay, and forks share them as long as nobody touches them
    gc.enable()  # disabled by the client; compiling leaves garbage
    slot = WorkerSlot.from_json(slot_json)
    with socket.socket(fileno=int(descriptor)) as control:
        warm_up(slot.cores().announce_part)
        Zygote(control, slot).serve()
