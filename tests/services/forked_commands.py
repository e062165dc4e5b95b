"""Commands that a service runs for each upload and download, forked where they are loaded already.

Each of these processes starts Python and loads its libraries, and the one that draws the camera
loads its compiled code, for more than a second: almost all of what tests of uploads took. The
processes are as limited as those that the service starts, and run the same function. Tests that
are about their start use `started_anew`.
"""

import atexit
import json
import os
import platform
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from seamark.mission_logs import limited
from seamark.server.programs import reader
from seamark.server.runs.downloads import conversions
from tests.services import fork_server

_NUMBER_BYTES_MAX = 32
_ENVIRONMENT = 6  # its place among the arguments of `_execute_child`
_PIPES = slice(10, 16)  # and those of the pipes: of this end and the other, by turns
_LATER = {  # module of a command -> what it loads for what it is asked; not what starts threads
    "seamark.server.programs.reader_process": (
        "seamark.sim.vehicles.plausibility",
        "seamark.sim.vehicles.report",
    ),
    "seamark.server.runs.downloads.conversion_process": (
        "seamark.formats.archive",
        "seamark.formats.ros.mcap_file",
        fork_server.CAMERA,
    ),
    "seamark.mission_logs.process": ("seamark.mission_logs.measuring", fork_server.CAMERA),
}
_HOW = [sys.executable, "-I", "-m"]
_USERS = (reader, conversions, limited)  # modules that start them


class _ForkServer:
    """Loads the module of a command and forks its processes."""

    def __init__(self, module: str) -> None:
        self._connection, its_end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._lock = threading.Lock()
        script = [sys.executable, "-I", fork_server.__file__, str(its_end.fileno())]
        self._process = subprocess.Popen(
            [*script, module, *_LATER[module]],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            pass_fds=[its_end.fileno()],
        )
        its_end.close()
        atexit.register(self.close)

    def fork(self, environment: dict[str, str], streams: list[int]) -> int:
        """Return the number of a new process, which is a child of this one."""
        request = {"environment": environment, "folder": str(Path.cwd())}
        with self._lock:
            socket.send_fds(self._connection, [json.dumps(request).encode()], streams)
            return int(self._connection.recv(_NUMBER_BYTES_MAX))

    def close(self) -> None:
        """End it; its processes are not its children."""
        self._connection.close()
        self._process.wait()


@cache
def _of(_owner: int, module: str) -> _ForkServer:
    """Return the server of a process of tests: a fork of that process has its own."""
    return _ForkServer(module)


class ForkedCommand(subprocess.Popen[bytes]):
    """A process whose command is one of ours; any other is started as always."""

    def _execute_child(self, *arguments: Any) -> None:
        """Do what the method of the standard library does, without an interpreter to start."""
        *how, module = arguments[0]
        if how != _HOW or module not in _LATER:
            super()._execute_child(*arguments)  # type: ignore[misc]
            return
        its_stdin, _, _, its_stdout, _, its_stderr = pipes = arguments[_PIPES]
        server = _of(os.getpid(), module)
        self.pid = server.fork(arguments[_ENVIRONMENT], [its_stdin, its_stdout, its_stderr])
        self._child_created = True
        self._close_pipe_fds(*pipes)  # type: ignore[attr-defined]


class _Subprocess:
    """The module `subprocess` for those who start our commands."""

    Popen = ForkedCommand

    def __getattr__(self, name: str) -> Any:
        return getattr(subprocess, name)

    def run(
        self,
        command: tuple[str, ...],
        *,
        input: bytes,
        timeout: float,
        env: dict[str, str],
        **_: Any,
    ) -> subprocess.CompletedProcess[bytes]:
        """Do what the function does that `limited` calls."""
        pipe = subprocess.PIPE
        with ForkedCommand(command, stdin=pipe, stdout=pipe, stderr=pipe, env=env) as process:
            try:
                output, errors = process.communicate(input, timeout=timeout)
            except BaseException:
                process.kill()
                raise
            return subprocess.CompletedProcess(command, process.wait(), output, errors)


def share() -> None:
    """Let the commands be forked from now on, where a process can have a sibling."""
    if platform.machine() in fork_server.CLONE:
        for module in _USERS:
            module.subprocess = _Subprocess()  # type: ignore[attr-defined]


@contextmanager
def started_anew() -> Iterator[None]:
    """Let the commands start as the service starts them."""
    before = [vars(module)["subprocess"] for module in _USERS]
    for module in _USERS:
        module.subprocess = subprocess  # type: ignore[attr-defined]
    yield
    for module, found in zip(_USERS, before, strict=True):
        module.subprocess = found  # type: ignore[attr-defined]
