"""Forks the processes of one command, whose modules it has loaded once.

    python -I fork_server.py DESCRIPTOR MODULE [MODULE THAT IT LOADS LATER...]

`forked_commands` starts it. Each request on the socket is a line of JSON with the environment and
folder of a process, and its three standard streams; the answer is its number. The process is a
child of whoever started this one, which waits for it and kills it as if it had started it.
"""

import ctypes
import gc
import json
import os
import platform
import signal
import socket
import sys
import tempfile
import traceback
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pkgutil import resolve_name
from typing import Any, NoReturn

CLONE = {"x86_64": 56, "aarch64": 220}  # number of the system call
CAMERA = "seamark.sim.engine.replay"
_CLONE_PARENT = 0x8000  # the new process is a sibling of this one
_REQUEST_BYTES_MAX = 1 << 16
_FAILED = 1  # as of an interpreter that ends with an exception


def main() -> None:
    """Fork until nobody is connected any more."""
    descriptor, module, *later = sys.argv[1:]
    connection = socket.socket(fileno=int(descriptor))
    run = resolve_name(f"{module}:main")
    for name in later:
        import_module(name)
    if CAMERA in later:
        _see()
    gc.freeze()  # forks share what is loaded as long as nobody touches it
    while True:
        request, streams, _, _ = socket.recv_fds(connection, _REQUEST_BYTES_MAX, 3)
        if not request:
            return
        number = _fork_beside()
        if number == 0:
            connection.close()
            _be(run, json.loads(request), streams)
        for stream in streams:
            os.close(stream)
        connection.send(str(number).encode())


def _see() -> None:
    """Render an image, which loads the compiled code of the camera."""
    import numpy as np

    from seamark.sim import registry
    from seamark.sim.engine.replay import Replay

    config = registry.benchmark(registry.DEFAULT_BENCHMARK).read({})
    row = np.zeros(config.telemetry_shape()[1])
    Replay(registry.DEFAULT_BENCHMARK, config, lambda _trial: 0).frame(row)


def _fork_beside() -> int:
    """Return the number of a new process, in which it is 0."""
    python = ctypes.pythonapi
    python.PyOS_BeforeFork()
    number = ctypes.CDLL(None).syscall(
        CLONE[platform.machine()], _CLONE_PARENT | signal.SIGCHLD, 0, 0, 0, 0
    )
    if number == 0:
        python.PyOS_AfterFork_Child()
    else:
        python.PyOS_AfterFork_Parent()
    return int(number)


def _be(run: Callable[[], None], request: Mapping[str, Any], streams: list[int]) -> NoReturn:
    """Run the command as an interpreter of its own would."""
    status = _FAILED
    try:
        settle(request, streams)
        run()
        sys.stdout.flush()
        status = 0
    except BaseException:  # as the interpreter does at last
        traceback.print_exc()
        sys.stderr.flush()
    finally:
        os._exit(status)  # not back into the loop of the process that was forked


def settle(request: Mapping[str, Any], streams: Sequence[int]) -> None:
    """Take the standard streams, the environment and the folder that a request has for a fork."""
    for place, stream in enumerate(streams):
        os.dup2(stream, place)
        os.close(stream)
    os.environ.clear()
    os.environ.update(request["environment"])
    os.chdir(request["folder"])
    tempfile.tempdir = None  # it may have been read from another environment


if __name__ == "__main__":
    main()
