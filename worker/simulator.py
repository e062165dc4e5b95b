"""The simulator zygote: one warm process per celery child, which forks a child for each run.

    python -s -P -m worker.simulator <descriptor> <place> <parent>

It loads the simulator and its compiled code once. A job comes in as one packet on the descriptor,
with the socket on which the child tells what happens. One child waits beforehand, with a Python box
started, so that a run begins in milliseconds. Nothing of a run survives in the zygote: the child
that ran it ends.
"""

import os
import select
import socket
import sys
import traceback
from dataclasses import asdict

from sandbox.level import Level
from sandbox.pool import Pool
from server import run_limits
from sim.warm_up import warm_up
from worker import frames
from worker.boxed import real_boxes, real_compiler
from worker.checking import check
from worker.frames import Kind
from worker.job import Job, Place
from worker.process_control import die_with_parent, limit_simulator, pin
from worker.telling import Telling
from worker.trials import Ending, Evaluation

READY = b"ready"  # sent once on the control socket when everything is loaded and compiled
JOB_MAX = 128 * 1024  # [byte]
CPU_LIMIT_S = 4 * 3600  # [s] of one simulator child
STOCK = {"python": 1}  # the others start in a tenth of the time: they have no NumPy to load
LONGEST_TRIAL_S = 3600.0  # [s] simulated, for which boxes in stock are good
LOOK_S = 30.0  # [s] between two looks at the age of what waits


class Zygote:
    """Keeps one child waiting for the next job."""

    def __init__(self, control: socket.socket, place: Place) -> None:
        self._control = control
        self._place = place
        self._parent = os.getpid()
        self._spare: Spare | None = None
        self._children: dict[int, int] = {}  # pidfd -> pid

    def serve(self) -> None:
        """Take jobs until the celery child ends."""
        self._prepare()
        self._control.send(READY)
        while True:
            control = self._control.fileno()
            ready, _, _ = select.select([control, *self._children], [], [])
            for descriptor in ready:
                if descriptor != control:
                    self._reap(descriptor)
                elif not self._take_job():
                    return

    def _take_job(self) -> bool:
        packet, descriptors, _, _ = socket.recv_fds(self._control, JOB_MAX, 1)
        if not packet:
            return False
        if self._spare is None:
            self._prepare()
        assert self._spare is not None  # noqa: S101 - _prepare made it
        spare, self._spare = self._spare, None
        with spare.channel:
            socket.send_fds(spare.channel, [packet], descriptors)
        for descriptor in descriptors:
            os.close(descriptor)
        return True

    def _prepare(self) -> None:
        mine, childs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        pid = os.fork()
        if pid == 0:
            mine.close()
            self._control.close()
            _live(childs, self._place, self._parent)
        childs.close()
        self._spare = Spare(pid, mine)
        self._children[os.pidfd_open(pid)] = pid

    def _reap(self, pidfd: int) -> None:
        """Forget a child that ended, and prepare the next one now that the core is free."""
        pid = self._children.pop(pidfd)
        os.close(pidfd)
        os.waitpid(pid, 0)
        if self._spare is not None and self._spare.pid == pid:
            self._spare.channel.close()
            self._spare = None  # not made anew before it is needed: it may die again
        elif self._spare is None:
            self._prepare()


class Spare:
    """A child that waits for a job, and the socket on which it gets it."""

    def __init__(self, pid: int, channel: socket.socket) -> None:
        self.pid = pid
        self.channel = channel


def _live(channel: socket.socket, place: Place, parent: int) -> None:
    """Be a simulator child: never returns."""
    status = 70  # EX_SOFTWARE
    try:
        die_with_parent(parent)
        limit_simulator(CPU_LIMIT_S)
        pin(place.core)
        _wait_and_run(channel, place)
        status = 0
    finally:  # whatever happened, the zygote's code must not run a second time in here
        if status:
            traceback.print_exc()
        sys.stderr.flush()
        os._exit(status)


def _wait_and_run(channel: socket.socket, place: Place) -> None:
    with _pool(place) as pool:
        pool.refill()
        while not select.select([channel], [], [], LOOK_S)[0]:
            pool.refill()  # nobody waits now
        packet, descriptors, _, _ = socket.recv_fds(channel, JOB_MAX, 1)
        if not packet:
            return
        with socket.socket(fileno=descriptors[0]) as out:
            frames.send(out, Kind.HELLO, {"pid": os.getpid()})
            try:
                place.cores().move_in()
                ending = evaluate(Job.from_json(packet), out, place, pool)
            finally:
                if sys.exc_info()[0] is not None:
                    frames.send(out, Kind.ERROR, traceback.format_exc().encode())
            frames.send(out, Kind.ENDING, asdict(ending))


def evaluate(job: Job, out: socket.socket, place: Place, pool: Pool) -> Ending:
    """Evaluate the job, telling everything to `out`."""
    cores = place.cores_for(len(job.seeds))
    # Trials side by side are processes of their own, and a box belongs to the one that made it.
    make = pool.take if cores is None else real_boxes(place)
    compile_ = real_compiler(place)
    if job.check:
        return check(job, Telling(out), make, compile_)
    return Evaluation(job, Telling(out), make, compile_program=compile_, cores=cores).run()


def _pool(place: Place) -> Pool:
    """Return the boxes that wait with a simulator child."""
    limits = run_limits.for_trial(LONGEST_TRIAL_S)
    stock = {} if place.level is Level.NONE else STOCK
    return Pool(stock, limits=limits, level=place.level, core=place.core)


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
