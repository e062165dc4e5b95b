"""The Celery child's end of its simulator: starts the zygote, begins and stops simulations."""

import contextlib
import os
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

import structlog

from seamark.sim.numerics.numba_internals import numba_folder
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.worker_slot import NO_MOTHER, WorkerSlot
from seamark.worker.ipc.fork_server import Process, ask
from seamark.worker.ipc.listener import Listener, deliver
from seamark.worker.ipc.messages import BoxFailed, Crashed, Reader, RunEnded, Started
from seamark.worker.ipc.outcomes import RunOutcome

# Of modules hardly anything is garbage, and to look for it takes a sixth of the start.
_START = (
    "import gc, sys; gc.disable()\nfrom seamark.worker.zygote.{} import main; main(sys.argv[1:])"
)
PROGRAM = ("-c", _START.format("process"))
MOTHER = ("-c", _START.format("mother"))
READY_MAX = 16  # [byte]
STOP_WITHIN_S = 2.0  # [s] for the zygote to remove its boxes; it takes some milliseconds
MOTHER_MAX_S = 1800.0  # [s] for which a zygote is awaited: its mother may be compiling
MESSAGE_S = 0.2  # [s] to wait for the next message of a simulation
_log = structlog.get_logger()


class SimulatorBroken(Exception):
    """The simulator died, crashed or stalled: a failure of the platform, the run is released."""


class BoxBroken(SimulatorBroken):
    """A box failed by itself, not by its program."""


class Mother:
    """The mother of a worker's zygotes: a process that is warm, and forks them."""

    def __init__(self, process: "subprocess.Popen[bytes]", requests: socket.socket) -> None:
        self._process, self._requests = process, requests

    @classmethod
    def start(cls, slot: WorkerSlot, cache: Path) -> Self:
        """Start the mother of the zygotes of all slots, of which one is given; returns at once.

        It may outlive this process: until all others that have its descriptor have ended.
        """
        requests, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            return cls(_interpreter(MOTHER, theirs, slot, cache), requests)

    @property
    def descriptor(self) -> int:
        """The descriptor on which it takes requests, for the slots of this process's children."""
        return self._requests.fileno()

    def stop(self) -> None:
        """End the mother, and all zygotes that are left."""
        self._requests.close()
        self._process.kill()
        self._process.wait()


class Simulator:
    """A zygote process that belongs to this process and dies with it.

    The mother of its slot forks it; without one, or when the mother is gone or hangs, it is a new
    interpreter, which has to load everything. `program` is what that starts; only tests choose
    another.
    """

    def __init__(self, slot: WorkerSlot, cache: Path, *, program: Sequence[str] = PROGRAM) -> None:
        self._slot = slot
        self._cache = cache
        self._program = tuple(program)
        self._warm = False
        self._process: Process | None = None
        self._started_at = 0.0  # monotonic
        self._control: socket.socket | None = None
        self._mother = slot.mother

    def start(self) -> None:
        """Start the zygote unless it is running; returns at once, it warms up by itself."""
        if self._awaited_long:
            self._disown("no zygote came")
        elif self._process is not None and self._process.poll() is None:
            return
        self.stop()
        self._warm = False
        self._started_at = time.monotonic()
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self._process = self._forked(theirs) or _interpreter(
                self._program, theirs, self._slot, self._cache
            )

    def _forked(self, theirs: socket.socket) -> Process | None:
        """Ask for a fork of the mother; None if there is no mother."""
        if self._mother == NO_MOTHER:
            return None
        try:
            with socket.socket(fileno=os.dup(self._mother)) as mother:
                return ask(mother, self._slot.to_json().encode(), [theirs.fileno()])
        except OSError as error:
            self._disown(str(error))
            return None

    @property
    def _awaited_long(self) -> bool:
        """Whether the mother had time enough for what has not come."""
        if self._mother == NO_MOTHER or self._control is None or self._warm:
            return False
        if time.monotonic() - self._started_at <= MOTHER_MAX_S:
            return False
        # A zygote that nobody waited for may have said long ago that it is warm.
        return not select.select([self._control], [], [], 0.0)[0]

    def _disown(self, why: str) -> None:
        """Do without the mother from now on."""
        _log.warning("mother_gone", why=why, core=self._slot.core)
        self._mother = NO_MOTHER

    def wait_warm(self, timeout_s: float) -> bool:
        """Return whether the zygote can take a job at once, after waiting for it a while.

        The very first start compiles the simulator, which takes minutes on a busy machine: a run
        claimed meanwhile would wait here instead of at a worker that is ready.

        Raises
        ------
        SimulatorBroken
            When the zygote ended before it was ready.
        """
        # One that ended during its start is reported below.
        if self._process is None or self._warm or self._awaited_long:
            self.start()
        assert self._control is not None  # noqa: S101 - start made it
        if not self._warm and select.select([self._control], [], [], timeout_s)[0]:
            self._warm = bool(self._control.recv(READY_MAX))
            if not self._warm:
                self.stop()
                raise SimulatorBroken("the zygote ended before it was ready")
        return self._warm

    def begin(self, job: Job) -> "Simulation":
        """Give a job to the zygote; raises SimulatorBroken if it is gone."""
        self.start()
        assert self._control is not None  # noqa: S101 - start made it
        mine, childs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        with childs:
            try:
                socket.send_fds(self._control, [job.to_json()], [childs.fileno()])
            except OSError as error:
                mine.close()
                self.stop()
                raise SimulatorBroken(f"the zygote takes no job: {error}") from error
        return Simulation(mine)

    def stop(self) -> None:
        """End the zygote and all its children; if it is warm, it removes its boxes itself."""
        if self._control is not None:
            self._control.close()
            self._control = None
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(STOP_WITHIN_S if self._warm else 0.0)
            self._process.send_signal(signal.SIGKILL)
            with contextlib.suppress(subprocess.TimeoutExpired):  # of a mother that hangs
                self._process.wait(STOP_WITHIN_S)
            self._process, self._warm = None, False


def _interpreter(
    program: Sequence[str], control: socket.socket, slot: WorkerSlot, cache: Path
) -> "subprocess.Popen[bytes]":
    """Start a zygote, or a mother, that this process controls by the other end of a socket."""
    arguments = [str(control.fileno()), slot.to_json(), str(os.getpid())]
    return subprocess.Popen(
        [sys.executable, "-s", "-P", *program, *arguments],
        pass_fds=[control.fileno(), *slot.inherited_descriptors()],
        stdin=subprocess.DEVNULL,
        env=os.environ | _compiled_code_cache(cache),
    )


def _compiled_code_cache(cache: Path) -> dict[str, str]:
    """Return Numba's setting where it cannot keep its code in its folder."""
    folder = numba_folder(os.environ)
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    return {} if os.access(folder, os.W_OK) else {"NUMBA_CACHE_DIR": str(cache)}


class Simulation:
    """One running evaluation."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel
        self._reader = Reader(channel)
        self._pidfd: int | None = None
        self._received_at = time.monotonic()
        self.started_at: float | None = None  # monotonic, when a child had taken the job

    @property
    def started(self) -> bool:
        """Whether a child has taken the job."""
        return self.started_at is not None

    @property
    def silent_s(self) -> float:
        """How long ago the last message came [s]."""
        return time.monotonic() - self._received_at

    def run(self, listener: Listener, watch: Callable[[], None]) -> RunOutcome:
        """Call `listener` until the evaluation ends, and return how it ended.

        Parameters
        ----------
        watch
            Called several times a second; an exception of it ends the wait.

        Raises
        ------
        SimulatorBroken, StreamBroken
            The child crashed, or is gone without an outcome; it sent what is no message.
        """
        while True:
            for message in self._reader.read(MESSAGE_S):
                self._received_at = time.monotonic()
                match message:
                    case Started(pid):
                        self._open_pidfd(pid)
                    case RunEnded(outcome):
                        return outcome
                    case BoxFailed(reason):
                        raise BoxBroken(reason)
                    case Crashed(traceback):
                        raise SimulatorBroken(f"the simulator child crashed:\n{traceback}")
                    case _:
                        deliver(message, listener)
            if self._reader.closed:
                raise SimulatorBroken("the simulator child died")
            watch()

    def _open_pidfd(self, pid: int) -> None:
        self.started_at = time.monotonic()
        # A child that has ended already, and was reaped, may have sent its outcome before.
        with contextlib.suppress(ProcessLookupError):
            self._pidfd = os.pidfd_open(pid)

    def close(self) -> None:
        """Kill the child, with its box; it may have ended already."""
        self._channel.close()
        if self._pidfd is None:
            return  # it finds its channel closed as soon as it takes the job
        try:
            signal.pidfd_send_signal(self._pidfd, signal.SIGKILL)
        except ProcessLookupError:
            pass
        os.close(self._pidfd)
        self._pidfd = None

    def __enter__(self) -> Self:  # noqa: D105
        return self

    def __exit__(  # noqa: D105
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
