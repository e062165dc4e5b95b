"""Forks runners, each of which serves one socket: a process of tests is much larger than this one.

Its standard input is a socket. Each message is a byte with a runner's own socket. The answer is the
number of the process, and when it has ended, its exit code.
"""

import gc
import os
import socket
import struct
import sys
from functools import cache
from typing import NoReturn

from seamark.sandbox.languages.inside.connection import Connection
from seamark.sandbox.languages.python.inside.runner import Runner
from seamark.sandbox.languages.python.inside.values import Observation

NUMBER = struct.Struct("<i")


@cache
def forks() -> socket.socket:
    """Return where this process asks for runners; they end with it."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with theirs:
        streams = [(os.POSIX_SPAWN_DUP2, theirs.fileno(), 0)]
        nowhere = [(os.POSIX_SPAWN_OPEN, one, os.devnull, os.O_RDWR, 0) for one in (1, 2)]
        command = [sys.executable, "-s", "-P", __file__]
        os.posix_spawn(command[0], command, os.environ, file_actions=[*streams, *nowhere])
    return ours


def serve(requests: socket.socket) -> None:
    """Fork until nobody is connected any more."""
    gc.freeze()  # forks share what is loaded as long as nobody touches it
    while True:
        asked, descriptors, _, _ = socket.recv_fds(requests, 1, 1)
        if not asked:
            return
        pid = os.fork()
        if pid == 0:
            become_runner(descriptors[0])
        os.close(descriptors[0])
        requests.send(NUMBER.pack(pid))
        requests.send(NUMBER.pack(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])))


def become_runner(descriptor: int) -> NoReturn:
    """Be the runner in this fork."""
    try:
        os.dup2(1, 0)
        Observation._fields.clear()
        Runner(Connection(descriptor)).run()
    finally:
        os._exit(99)


if __name__ == "__main__":
    serve(socket.socket(fileno=0))
