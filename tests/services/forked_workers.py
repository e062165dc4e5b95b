"""Workers that are forked where all that they load is loaded already, once for all tests.

A worker's main process and the mother of its zygotes load Celery, Numba and the simulator for four
seconds of CPU time. The forks run the same functions. Tests that are about the start of a worker,
or about what each of its processes has loaded, start one anew.
"""

import atexit
import json
import os
import signal
import socket
import subprocess
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import IO, Any

from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.ipc import fork_server
from seamark.worker.service.command_line import ONE_THREAD
from seamark.worker.zygote.client import Mother
from tests.services import worker_server

LOADED_S = 900.0  # in which it has loaded everything: a first start compiles the simulator
NO_MORE: Mapping[str, str] = {}
_STDERR = 2
_ROOM = "room for the command of a worker or of the mother of its zygotes " * 12


class ForkedWorker:
    """A process that has been forked; what a test does with it is what it does with a `Popen`."""

    def __init__(self, process: fork_server.ForkedProcess) -> None:
        assert process.started(LOADED_S)
        assert process._pidfd is not None
        self._process = process
        self.pid = _process_of(process._pidfd)

    def send_signal(self, number: int) -> None:
        self._process.send_signal(number)

    def terminate(self) -> None:
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)

    def wait(self, timeout: float | None = None) -> int:
        return self._process.wait(timeout)


def _process_of(pidfd: int) -> int:
    lines = Path(f"/proc/self/fdinfo/{pidfd}").read_text().splitlines()
    return next(int(line.removeprefix("Pid:")) for line in lines if line.startswith("Pid:"))


@cache
def prepare() -> socket.socket:
    """Start the server, which loads nothing yet; return where it and its forks are asked for.

    Processes that are forked afterwards ask the same one.
    """
    requests, its_end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    script = [*worker_server.INTERPRETER, worker_server.__file__, str(its_end.fileno()), _ROOM]
    process = subprocess.Popen(
        script,
        env=os.environ | ONE_THREAD,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        pass_fds=[its_end.fileno()],
    )
    its_end.close()
    atexit.register(_end, process, os.getpid())
    return requests


def _end(process: "subprocess.Popen[bytes]", owner: int) -> None:
    if os.getpid() == owner:
        process.kill()
        process.wait()


def start(
    arguments: list[str], environment: dict[str, str], log: IO[bytes] | None = None
) -> ForkedWorker:
    """Start a worker, in a session of its own, as `python` does with the arguments."""
    output = _STDERR if log is None else log.fileno()
    values = {"arguments": arguments, "environment": environment, "folder": str(Path.cwd())}
    return ForkedWorker(_ask("worker", values, output))


def mother(slot: WorkerSlot, benchmarks: Mapping[str, str] = NO_MORE) -> Mother:
    """Start a mother of zygotes, which know some more benchmarks if wanted."""
    requests, her_end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with her_end:
        values = {"slot": slot.to_json(), "benchmarks": dict(benchmarks)}
        process: Any = ForkedWorker(_ask("mother", values, her_end.fileno()))
    return Mother(process, requests)


def _ask(kind: str, values: Mapping[str, object], descriptor: int) -> fork_server.ForkedProcess:
    return fork_server.ask(prepare(), json.dumps([kind, values]).encode(), [descriptor])
