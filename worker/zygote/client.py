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

from seamark.sim.numerics.numba_internals import numba_folder
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.ipc.listener import Listener, deliver
from seamark.worker.ipc.messages import BoxFailed, Crashed, Reader, RunEnded, Started
from seamark.worker.ipc.outcomes import RunOutcome

# Of modules hardly anything is garbage, and to look for it takes a sixth of the start.
PROGRAM = (
    "-c",
    "import gc, sys; gc.disable()\n"
    "from seamark.worker.zygote.process import main; main(sys.argv[1:])",
)
READY_MAX = 16  # [byte]
STOP_WITHIN_S = 2.0  # [s] for the zygote to remove its boxes; it takes some milliseconds
MESSAGE_S = 0.2  # [s] to wait for the next message of a simulation


class SimulatorBroken(Exception):
    """The simulator died, crashed or stalled: a failure of the platform, the run is released."""


class BoxBroken(SimulatorBroken):
    """A box failed by itself, not by its program."""


class Simulator:
    """A zygote process that belongs to this process and dies with it.

    `program` is what the interpreter starts; only tests choose another.
    """

    def __init__(self, slot: WorkerSlot, cache: Path, *, program: Sequence[str] = PROGRAM) -> None:
        self._slot = slot
        self._cache = cache
        self._program = tuple(program)
        self._warm = False
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None

    def start(self) -> None:
        """Start the zygote unless it is running; returns at once, it warms up by itself."""
        if self._process is not None and self._process.poll() is None:
            return
        self.stop()
        self._warm = False
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        arguments = [str(theirs.fileno()), self._slot.to_json(), str(os.getpid())]
        command = [sys.executable, "-s", "-P", *self._program, *arguments]
        with theirs:
            self._process = subprocess.Popen(
                command,
                pass_fds=[theirs.fileno(), *self._slot.inherited_descriptors()],
                stdin=subprocess.DEVNULL,
                env=os.environ | _compiled_code_cache(self._cache),
            )

    def wait_warm(self, timeout_s: float) -> bool:
        """Return whether the zygote can take a job at once, after waiting for it a while.

        The very first start compiles the simulator, which takes minutes on a busy machine: a run
        claimed meanwhile would wait here instead of at a worker that is ready.

        Raises
        ------
        SimulatorBroken
            When the zygote ended before it was ready.
        """
        if self._process is None or self._warm:  # one that ended during its start is reported below
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
            self._process.kill()
            self._process.wait()
            self._process, self._warm = None, False


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
