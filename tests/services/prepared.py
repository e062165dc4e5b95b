"""Interpreters that have loaded the simulator once, and of which programs of tests are forks.

A program of a test has the environment, hashes and processor of such an interpreter, which has
computed nothing: none of what the process of the tests has done can be seen in it. What is loaded
takes more than a second each time, mostly longer than what the program computes. The one that is
warm has loaded the compiled code as well, as a worker's has. Tests that are about loading start
Python themselves.

All processes of the tests share one interpreter of each kind (`tests.services.forked_processes`).
"""

import atexit
import gc
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

from tests.services import fork_server
from tests.sim.oldest_processor import OLDEST_LIBRARIES, OLDEST_PROCESSOR

_ROOT = Path(__file__).parents[2]
_ELSEWHERE = {"PYTHONHASHSEED": "1", "OMP_NUM_THREADS": "1"}
KINDS: dict[str, dict[str, str]] = {
    "another": _ELSEWHERE,
    "warm": _ELSEWHERE,
    "oldest": {**_ELSEWHERE, **OLDEST_PROCESSOR, **OLDEST_LIBRARIES},
}
_LOADED = ("seamark.sim.engine.summary", fork_server.CAMERA)
_LOADED_BY_TESTS = ("hypothesis.extra.numpy", "pytest")
SEAMARK = "from seamark.cli.main import main; main()"  # the command line as a program
_REQUEST_BYTES_MAX = 1 << 17
_STREAMS = 3
_FAILED = 1  # as of an interpreter that ends with an exception


class _Interpreter:
    def __init__(self, kind: str) -> None:
        self._connection, its_end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        code = "from tests.services.prepared import serve; serve()"
        # NumPy warns of a feature that cannot be left out.
        python = [sys.executable, "-W", "error::ImportWarning"]
        self._process = subprocess.Popen(
            [*python, "-c", code, kind, str(its_end.fileno())],
            cwd=_ROOT,
            env={**os.environ, **KINDS[kind]},
            stdin=subprocess.DEVNULL,
            pass_fds=[its_end.fileno()],
        )
        its_end.close()
        atexit.register(self._end, os.getpid())

    def run(self, request: Mapping[str, object], streams: list[int]) -> int:
        """Return the exit code of a program."""
        said, to_say = os.pipe()
        with open(said, "rb") as answer:
            socket.send_fds(self._connection, [json.dumps(request).encode()], [*streams, to_say])
            os.close(to_say)
            # Not to its end, which whatever the program has started may hold open.
            return int(answer.readline() or -signal.SIGKILL)  # it was killed

    def _end(self, owner: int) -> None:
        if os.getpid() == owner:  # its forks have inherited what it does at its end
            self._connection.close()
            self._process.kill()
            self._process.wait()


@cache
def _interpreter(kind: str) -> _Interpreter:
    return _Interpreter(kind)


def share() -> None:
    """Start one of each kind for all forks of this process; it loads nothing until it is asked."""
    for kind in KINDS:
        _interpreter(kind)


def run(
    program: str,
    *arguments: str,
    on: str = "another",
    folder: Path | None = None,
    environment: Mapping[str, str] | None = None,
) -> "subprocess.CompletedProcess[str]":
    """Run a program as `python -c` does, in a fork of an interpreter of this kind."""
    request = {
        "program": program,
        "arguments": ["-c", *arguments],
        "folder": str(folder or Path.cwd()),
        "environment": {**(os.environ if environment is None else environment), **KINDS[on]},
    }
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
        with open(os.devnull, "rb") as nothing:
            streams = [nothing.fileno(), output.fileno(), errors.fileno()]
            status = _interpreter(on).run(request, streams)
        said = [_text(file.fileno()) for file in (output, errors)]
    return subprocess.CompletedProcess(["-c", *arguments], status, *said)


def _text(descriptor: int) -> str:
    return os.pread(descriptor, os.fstat(descriptor).st_size, 0).decode()


def printed(program: str, *arguments: str, on: str = "another") -> str:
    """Return what a program prints that must not fail."""
    done = run(program, *arguments, on=on)
    assert done.returncode == 0, done.stderr
    return done.stdout


def serve() -> None:
    """Fork until nobody is connected any more."""
    connection = socket.socket(fileno=int(sys.argv[2]))
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # programs tell their exit codes themselves
    loaded = False
    while True:
        request, descriptors, _, _ = socket.recv_fds(connection, _REQUEST_BYTES_MAX, _STREAMS + 1)
        if not request:
            return
        if not loaded:
            _load(sys.argv[1])
            loaded = True
        if os.fork() == 0:
            connection.close()
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            _be(json.loads(request), *descriptors)
        for descriptor in descriptors:
            os.close(descriptor)


def _load(kind: str) -> None:
    from seamark.sim import registry
    from seamark.sim.engine.warm_up import warm_up

    registry.load_all()
    for name in _LOADED:
        import_module(name)
    if kind == "oldest":  # of whose programs some import the module of their test
        for name in _LOADED_BY_TESTS:
            import_module(name)
    if kind == "warm":
        warm_up()
    gc.collect()
    gc.freeze()  # forks share what is loaded as long as nobody touches it


def _be(request: dict[str, Any], *descriptors: int) -> NoReturn:
    """Run the program as an interpreter of its own would, and tell its exit code."""
    *streams, answer = descriptors
    os.set_inheritable(answer, False)
    fork_server.settle(request, streams)
    sys.argv[:] = request["arguments"]
    status = _exit_code(request["program"])
    with suppress(OSError, ValueError):  # as of an interpreter at its end
        sys.stdout.flush()
        sys.stderr.flush()
    os.write(answer, f"{status}\n".encode())
    os._exit(status)  # not back into the loop of the process that was forked


def _exit_code(program: str) -> int:
    main = sys.modules["__main__"] = ModuleType("__main__")
    try:
        exec(compile(program, "<string>", "exec"), vars(main))  # noqa: S102  our own
    except SystemExit as end:
        if end.code is None or isinstance(end.code, int):
            return end.code or 0
        sys.stderr.write(f"{end.code}\n")
        return _FAILED
    except BaseException:  # as the interpreter does at last
        traceback.print_exc()
        return _FAILED
    return 0
