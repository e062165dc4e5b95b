"""Forks workers, and mothers of zygotes, that have loaded before what they need.

    python -s -P worker_server.py DESCRIPTOR ROOM

`forked_workers` starts it and sends the requests, as JSON. It loads nothing before the first of
them. What it forks runs the functions that a new interpreter runs, with an environment, a folder
and a session of its own; the command in the list of processes takes the place of ROOM.
"""

import gc
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from seamark.worker.ipc.fork_server import DEFERRED, ForkServer, say_nothing
from seamark.worker.ipc.process_control import run_forked, show_as

INTERPRETER = [sys.executable, "-s", "-P"]
_ROOT = Path(__file__).parents[2]  # of the modules of tests in which benchmarks are
_PASSED, _PIPES = 4, slice(10, 16)  # places among the arguments of `_execute_child`
# All but what reads the settings as it is loaded.
_OF_WORKER = (
    "celery.apps.worker",
    "celery.bin.worker",
    "celery.concurrency.prefork",
    "celery.__main__",
    "kombu.transport.redis",
    "seamark.worker.service.bridge_loop",
    "seamark.worker.service.check_loop",
    "seamark.worker.service.host",
    "seamark.worker.service.main_process",
    "seamark.worker.service.maintenance",
    "seamark.worker.service.nursery",
    "seamark.worker.service.run_loop",
    "seamark.worker.service.side_processes",
)


def main() -> None:
    """Fork until nobody is connected any more."""
    control = socket.socket(fileno=int(sys.argv[1]))
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, DEFERRED)
    if not control.recv(1, socket.MSG_PEEK):
        return
    gc.disable()
    _load()
    gc.freeze()  # forks share what is loaded as long as nobody touches it
    ForkServer(control, _begin, mask=mask).serve()


def _load() -> None:
    for name in _OF_WORKER:
        import_module(name)
    from seamark.sim.engine.warm_up import warm_up
    from seamark.worker.zygote import mother

    warm_up()
    # It is for a new interpreter, and would load nothing more.
    mother.warm_up = lambda *_: None  # type: ignore[attr-defined]


def _begin(request: bytes, descriptors: list[int]) -> Callable[[], None]:
    """Return how a fork becomes what is asked for: the function for it, and its arguments."""
    kind, values = json.loads(request)
    [descriptor] = descriptors
    if kind == "worker":
        return partial(_be_worker, descriptor, **values)
    return partial(_be_mother, descriptor, **values)


def _be_worker(output: int, arguments: list[str], environment: dict[str, str], folder: str) -> None:
    from seamark.worker.service import main_process
    from seamark.worker.zygote import client

    os.setsid()
    for stream in (1, 2):
        os.dup2(output, stream)
    os.close(output)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    tempfile.tempdir = None  # it may have been read from another environment
    show_as([sys.executable, *arguments])
    sys.argv = [str(main_process.__file__), *arguments[arguments.index("-A") :]]
    client.subprocess = _Subprocess()  # type: ignore[assignment,attr-defined]
    main_process.main()


def _be_mother(requests: int, slot: str, benchmarks: dict[str, str]) -> None:
    from seamark.sim import registry
    from seamark.worker.zygote import client, mother

    sys.path.append(str(_ROOT))
    registry.BENCHMARKS |= benchmarks
    arguments = [str(requests), slot, str(os.getppid())]
    show_as([*INTERPRETER, *client.MOTHER, *arguments])
    mother.main(arguments)


class _ForkedMother(subprocess.Popen[bytes]):
    """The mother of a worker that has loaded what she loads; any other process is started."""

    def _execute_child(self, *arguments: Any) -> None:
        """Do what the method of the standard library does, without an interpreter to start."""
        from seamark.worker.zygote import client

        command = list(arguments[0])
        start = [*INTERPRETER, *client.MOTHER]
        if command[: len(start)] != start:
            super()._execute_child(*arguments)  # type: ignore[misc]
            return
        self.pid = os.fork()
        if self.pid == 0:
            body = partial(_be_mother_of_worker, command, len(start), arguments[_PASSED])
            run_forked(body, say_nothing)
        self._child_created = True
        self._close_pipe_fds(*arguments[_PIPES])  # type: ignore[attr-defined]


def _be_mother_of_worker(command: list[str], start: int, kept: list[int]) -> None:
    from seamark.worker.service import nursery
    from seamark.worker.zygote import mother

    nursery._forget_handlers()
    nursery._let_go_of_all_but(*kept)
    show_as(command)
    mother.main(command[start:])


class _Subprocess:
    """The module `subprocess` for who starts the mother."""

    Popen = _ForkedMother

    def __getattr__(self, name: str) -> Any:
        return getattr(subprocess, name)


if __name__ == "__main__":
    main()
