"""A process that has loaded something, and forks others that use it, on request.

Each fork belongs to who asked for it: it is killed when that one has ended, or has lost interest.
A request is one packet, with the descriptors that the fork gets beside the standard streams. What
has asked learns from a channel of its own that the fork has started, and how it has ended.
"""

import os
import select
import signal
import socket
import subprocess
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import NamedTuple, Protocol

from seamark.worker.ipc.process_control import die_with_parent, run_forked

PACKET_MAX = 64 * 1024  # [byte]
DESCRIPTORS_MAX = 2  # of a request, with that of its channel
DEFERRED = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)  # until a fork has its own handlers
Begin = Callable[[bytes, list[int]], Callable[[], None]]


class Process(Protocol):
    """A child process, or one that is as good as that: as `subprocess.Popen` has it."""

    def poll(self) -> int | None:
        """Return how it ended; None while it runs."""

    def wait(self, timeout: float | None = None) -> int:
        """Return how it ended; raises TimeoutExpired if it still runs then."""

    def send_signal(self, sig: int) -> None:
        """Send a signal, unless it has ended."""


def ask(control: socket.socket, request: bytes, descriptors: Sequence[int] = ()) -> "ForkedProcess":
    """Ask the server behind `control` for a fork; raises OSError if it is gone.

    Parameters
    ----------
    request, descriptors
        What the server's `begin` is called with; the descriptors have other numbers there.
    """
    channel, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    try:
        with theirs:
            socket.send_fds(control, [request], [theirs.fileno(), *descriptors])
    except OSError:
        channel.close()
        raise
    return ForkedProcess(channel)


class ForkedProcess:
    """A process that a server forks for this one.

    Its channel gives the process, and later its exit code. When the channel closes without one, the
    server is gone, and the kernel has killed the process.
    """

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel
        self._pidfd: int | None = None
        self._code: int | None = None

    def started(self, timeout: float | None) -> bool:
        """Return whether the server has forked it, after waiting for that a while."""
        self._look(timeout, until_started=True)
        return self._pidfd is not None

    def poll(self) -> int | None:
        """Return how it ended; None while it runs, or has not started yet."""
        return self._look(0.0)

    def wait(self, timeout: float | None = None) -> int:
        """Return how it ended; raises TimeoutExpired if that has not happened by then."""
        code = self._look(timeout)
        if code is None:
            raise subprocess.TimeoutExpired("a forked process", timeout or 0.0)
        return code

    def send_signal(self, sig: int) -> None:
        """Send a signal, unless it has ended; one that has not started does not start any more."""
        if self.poll() is not None:
            return
        if self._pidfd is None:
            self._end(-sig)
            return
        with suppress(ProcessLookupError):
            signal.pidfd_send_signal(self._pidfd, sig)

    def _look(self, timeout: float | None, *, until_started: bool = False) -> int | None:
        """Read what the server sends, until the end or the timeout."""
        while self._code is None and not (until_started and self._pidfd is not None):
            if not select.select([self._channel], [], [], timeout)[0]:
                break
            text, pidfds = _receive(self._channel, 1)
            if pidfds:
                self._pidfd = pidfds[0]
            else:
                self._end(int(text or -signal.SIGKILL))
        return self._code

    def _end(self, code: int) -> None:
        self._code = code
        self._channel.close()
        if self._pidfd is not None:
            os.close(self._pidfd)
            self._pidfd = None


class _Child(NamedTuple):
    """A fork, as the server sees it."""

    pid: int
    pidfd: int
    channel: socket.socket


class ForkServer:
    """Forks a process for each request on a socket."""

    def __init__(self, control: socket.socket, begin: Begin, *, mask: Iterable[int]) -> None:
        """Fork nothing yet.

        Parameters
        ----------
        begin
            Is called with each request and its descriptors, in the server; returns what the fork
            does.
        mask
            The signals that a fork blocks; the server itself blocks `DEFERRED`.
        """
        self._control, self._begin, self._mask = control, begin, mask
        self._children: dict[int, _Child] = {}  # by pidfd, and by their channels

    def serve(self) -> None:
        """Fork until nobody can ask for anything any more."""
        while True:
            for descriptor in select.select([self._control.fileno(), *self._children], [], [])[0]:
                if descriptor == self._control.fileno():
                    if not self._take_request():
                        return
                elif (child := self._children.get(descriptor)) is not None:
                    self._attend(child, descriptor)

    def _take_request(self) -> bool:
        """Fork what the next request wants; False if there is none, and will be none."""
        request, descriptors = _receive(self._control, DESCRIPTORS_MAX)
        if not request:
            return False
        channel, parent = socket.socket(fileno=descriptors[0]), os.getpid()
        body = self._begin(request, descriptors[1:])
        pid = os.fork()
        if pid == 0:
            die_with_parent(parent)
            self._let_go()
            channel.close()
            signal.pthread_sigmask(signal.SIG_SETMASK, self._mask)
            run_forked(body, say_nothing)
        for descriptor in descriptors[1:]:
            os.close(descriptor)
        pidfd = os.pidfd_open(pid)
        child = _Child(pid, pidfd, channel)
        self._children |= {pidfd: child, channel.fileno(): child}
        with suppress(OSError):  # nobody waits for it any more, as its channel says next
            socket.send_fds(channel, [b"started"], [pidfd])
        return True

    def _let_go(self) -> None:
        """Close what is the server's: done in a fork."""
        self._control.close()
        for child in set(self._children.values()):
            os.close(child.pidfd)
            child.channel.close()

    def _attend(self, child: _Child, descriptor: int) -> None:
        """Reap a fork that has ended and say how, or end one that nobody wants any more."""
        if descriptor != child.pidfd:
            with suppress(ProcessLookupError):
                signal.pidfd_send_signal(child.pidfd, signal.SIGKILL)
        del self._children[child.pidfd], self._children[child.channel.fileno()]
        os.close(child.pidfd)
        code = os.waitstatus_to_exitcode(os.waitpid(child.pid, 0)[1])
        with child.channel, suppress(OSError):
            child.channel.send(str(code).encode())


def _receive(channel: socket.socket, descriptors_max: int) -> tuple[bytes, list[int]]:
    """Receive a packet with its descriptors, which no program inherits."""
    packet, descriptors, _, _ = socket.recv_fds(
        channel, PACKET_MAX, descriptors_max, socket.MSG_CMSG_CLOEXEC
    )
    return packet, descriptors


def say_nothing(_: str) -> None:
    """Leave it at the traceback in the log."""
