"""The celery child's end of its simulator: starts the zygote, begins and stops simulations."""

import os
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from seamark import sim
from seamark.worker.evaluation.job import Job, Place
from seamark.worker.ipc.messages import Frame, Kind, Reader

PROGRAM = ("-m", "seamark.worker.zygote.process")
READY_MAX = 16  # [byte]


class SimulatorBroken(Exception):
    """The simulator died or fell silent: our failure, the run is given back."""


class Simulator:
    """A zygote process that belongs to this process and dies with it.

    `program` is what the interpreter starts; only tests choose another.
    """

    def __init__(self, place: Place, cache: Path, *, program: Sequence[str] = PROGRAM) -> None:
        self._place = place
        self._cache = cache
        self._program = tuple(program)
        self._warm = False
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None

    def start(self) -> None:
        """Start the zygote unless it runs; returns at once, it warms up by itself."""
        if self._process is not None and self._process.poll() is None:
            return
        self.stop()
        self._warm = False
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        facts = [str(theirs.fileno()), self._place.to_text(), str(os.getpid())]
        command = [sys.executable, "-s", "-P", *self._program, *facts]
        with theirs:
            self._process = subprocess.Popen(
                command,
                pass_fds=[theirs.fileno(), *self._place.descriptors()],
                stdin=subprocess.DEVNULL,
                env=os.environ | _compiled_code_at(self._cache),
            )

    def wait_warm(self, timeout_s: float) -> bool:
        """Return whether the zygote can take a job at once, after waiting for it a while.

        The first start of all compiles the simulator, which takes minutes on a busy machine: a run
        claimed meanwhile would wait here instead of at a worker that is ready.

        Raises
        ------
        SimulatorBroken
            When the zygote ended before it was ready.
        """
        if self._process is None or self._warm:  # one that ended while it starts is not hushed up
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
        """End the zygote and all its children."""
        if self._control is not None:
            self._control.close()
            self._control = None
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None


def _compiled_code_at(cache: Path) -> dict[str, str]:
    """Return Numba's setting where it cannot keep its code beside the sources."""
    beside = Path(sim.__file__).parent
    return {} if os.access(beside, os.W_OK) else {"NUMBA_CACHE_DIR": str(cache)}


class Simulation:
    """One running evaluation."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel
        self._reader = Reader(channel)
        self._pidfd: int | None = None

    @property
    def begun(self) -> bool:
        """Whether a child has taken the job."""
        return self._pidfd is not None

    def read(self, timeout_s: float) -> Iterator[Frame]:
        """Yield the messages that are there, after waiting for the first byte.

        Raises SimulatorBroken when the child is gone without having told its ending.
        """
        for frame in self._reader.read(timeout_s):
            if frame.kind is Kind.HELLO:
                self._take_hold(int(frame.json()["pid"]))
            else:
                yield frame
        if self._reader.ended:
            raise SimulatorBroken("the simulator child died")

    def _take_hold(self, pid: int) -> None:
        try:
            self._pidfd = os.pidfd_open(pid)
        except ProcessLookupError as error:
            raise SimulatorBroken("the simulator child died at its start") from error

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
