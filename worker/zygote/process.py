"""The simulator zygote: one warm process per celery child, which forks a child for each run.

    python -s -P -m seamark.worker.zygote.process <descriptor> <place> <parent>

It loads the simulator and its compiled code once. A job comes in as one packet on the descriptor,
with the socket on which the child tells what happens. Between runs, boxes of each language are
started and wait here, so that a run begins in milliseconds. Nothing of a run survives in the
zygote: the child that ran it ends, and its boxes with it.
"""

import os
import select
import socket
import sys
import traceback
from dataclasses import asdict
from typing import NamedTuple, NoReturn

from seamark.sandbox.pool import Loan, Pool
from seamark.sim.engine.warm_up import warm_up
from seamark.worker.evaluation.check import check
from seamark.worker.evaluation.evaluation import Ending, Evaluation
from seamark.worker.evaluation.job import Job, Place
from seamark.worker.evaluation.program_adapters import pool_of, real_compiler
from seamark.worker.ipc import messages
from seamark.worker.ipc.listener import Telling
from seamark.worker.ipc.messages import Kind
from seamark.worker.ipc.process_control import die_with_parent, limit_simulator, pin

READY = b"ready"  # sent once on the control socket when everything is loaded and compiled
JOB_MAX = 128 * 1024  # [byte]
CPU_LIMIT_S = 4 * 3600  # [s] of one simulator child
LOOK_S = 30.0  # [s] between two looks at the age of what waits


class Zygote:
    """Forks a child for each job; boxes wait with it meanwhile, and are lent to the child."""

    def __init__(self, control: socket.socket, place: Place) -> None:
        self._control = control
        self._place = place
        self._pool = pool_of(place)
        self._children: dict[int, Child] = {}  # by pidfd

    def serve(self) -> None:
        """Take jobs until the celery child ends."""
        self._control.send(READY)
        control = self._control.fileno()
        with self._pool:
            while True:
                if not self._children:
                    self._pool.refill()  # nobody waits now, and the core is free
                ready, _, _ = select.select([control, *self._children], [], [], LOOK_S)
                for descriptor in ready:
                    if descriptor != control:
                        self._reap(descriptor)
                    elif not self._take_job():
                        return

    def _take_job(self) -> bool:
        packet, descriptors, _, _ = socket.recv_fds(self._control, JOB_MAX, 1)
        if not packet:
            return False
        job, parent = Job.from_json(packet), os.getpid()
        loan = self._pool.lend(job.language, 0 if job.program is None else len(job.seeds))
        with socket.socket(fileno=descriptors[0]) as out:
            pid = os.fork()
            if pid == 0:
                self._control.close()
                loan.use()
                _live(job, out, self._place, self._pool, parent)
        loan.leave()
        self._children[os.pidfd_open(pid)] = Child(pid, loan)
        return True

    def _reap(self, pidfd: int) -> None:
        """Forget a child that ended; end what it could not end."""
        child = self._children.pop(pidfd)
        os.close(pidfd)
        os.waitpid(child.pid, 0)
        child.loan.close()


class Child(NamedTuple):
    """A process that evaluates a job, and the boxes that it was lent."""

    pid: int
    loan: Loan


def _live(job: Job, out: socket.socket, place: Place, pool: Pool, parent: int) -> NoReturn:
    """Be a simulator child: never returns."""
    status = 70  # EX_SOFTWARE
    try:
        die_with_parent(parent)
        limit_simulator(CPU_LIMIT_S)
        pin(place.core)
        _tell(job, out, place, pool)
        status = 0
    finally:  # whatever happened, the zygote's code must not run a second time in here
        if status:
            traceback.print_exc()
        sys.stderr.flush()
        os._exit(status)


def _tell(job: Job, out: socket.socket, place: Place, pool: Pool) -> None:
    """Evaluate the job, with the outcome or the failure as the last word."""
    messages.send(out, Kind.HELLO, {"pid": os.getpid()})
    try:
        place.cores().move_in()
        with pool:
            ending = evaluate(job, out, place, pool)
    finally:
        if sys.exc_info()[0] is not None:
            messages.send(out, Kind.ERROR, traceback.format_exc().encode())
    messages.send(out, Kind.ENDING, asdict(ending))


def evaluate(job: Job, out: socket.socket, place: Place, pool: Pool) -> Ending:
    """Evaluate the job, telling everything to `out`."""
    compile_ = real_compiler(place)
    if job.check:
        return check(job, Telling(out), pool.take, compile_)
    cores = place.cores_for(len(job.seeds))
    return Evaluation(
        job, Telling(out), pool.take, compile_program=compile_, cores=cores, pool=pool
    ).run()


def main(arguments: list[str]) -> None:
    """Be the zygote."""
    descriptor, place_text, parent = arguments
    die_with_parent(int(parent))
    place = Place.from_text(place_text)
    with socket.socket(fileno=int(descriptor)) as control:
        warm_up()
        Zygote(control, place).serve()


if __name__ == "__main__":
    main(sys.argv[1:])
