"""Where the side processes of a worker come from: a process that has loaded what they share.

Started by itself, each would spend half a second of CPU time on loading the same libraries again.
The worker's main process cannot fork them: when they have to start, and start again, it has threads
and connections. So it forks the nursery before it has any, and asks that one for the others, over a
socket. A side process gets what it would get from a new interpreter: the standard streams without
input, the arguments and the signals; and it ends with its worker.
"""

import importlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import NamedTuple, Protocol, Self

import structlog

from seamark.sandbox.isolation import proc_stats
from seamark.worker.ipc.process_control import die_with_parent, run_forked, show_as

PACKET_MAX = 64 * 1024  # [byte]
ANSWER_S = 30.0  # [s] in which the nursery has loaded a module, even on a busy machine
_INTERPRETER = (sys.executable, "-s", "-P")
_DEFERRED = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)  # until a fork has its own handlers
_log = structlog.get_logger()


class Process(Protocol):
    """What a worker does with a side process, as `subprocess.Popen` does it."""

    def poll(self) -> int | None:
        """Return how it ended; None while it runs."""

    def wait(self, timeout: float | None = None) -> int:
        """Return how it ended; raises TimeoutExpired if it still runs then."""

    def send_signal(self, sig: int) -> None:
        """Send a signal, unless it has ended."""


def spawn(command: Sequence[str]) -> Process:
    """Start a side process in a new interpreter.

    Parameters
    ----------
    command
        `-m`, a module and its arguments after the first one, which is this process.
    """
    whole = _INTERPRETER + _with_parent(command, os.getpid())
    return subprocess.Popen(whole, stdin=subprocess.DEVNULL)


class Nursery:
    """The nursery, as the main process of its worker sees it."""

    def __init__(self, pid: int, control: socket.socket) -> None:
        self._pid, self._control = pid, control

    @classmethod
    def fork(cls) -> Self | None:
        """Fork a nursery; None if this process has other threads: a fork keeps their locks."""
        threads = proc_stats.threads([os.getpid()])
        if len(threads) > 1:
            names = [one.name for one in threading.enumerate()]
            _log.warning("no_nursery", threads=len(threads), of_python=names)
            return None
        parent = os.getpid()
        control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            pid = os.fork()
            if pid == 0:
                run_forked(lambda: _be_nursery(theirs, parent), _say_nothing)
        return cls(pid, control)

    def start(self, command: Sequence[str]) -> Process:
        """Start a side process, as `spawn` does; in a new interpreter if the nursery is gone."""
        if self._control.fileno() >= 0:
            try:
                return self._ask_for(command)
            except OSError as error:
                _log.warning("nursery_gone", why=str(error))
                self.close()
        return spawn(command)

    def _ask_for(self, command: Sequence[str]) -> Process:
        channel, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            with theirs:
                socket.send_fds(self._control, [json.dumps(command).encode()], [theirs.fileno()])
            channel.settimeout(ANSWER_S)
            _, pidfds, _, _ = socket.recv_fds(channel, PACKET_MAX, 1)
            if not pidfds:
                raise ConnectionResetError("it has ended")
        except OSError:
            channel.close()
            raise
        os.set_inheritable(pidfds[0], False)
        return _Fork(channel, pidfds[0])

    def close(self) -> None:
        """End the nursery, and with it the side processes that it has forked."""
        self._control.close()
        with suppress(ProcessLookupError, ChildProcessError):
            os.kill(self._pid, signal.SIGKILL)
            os.waitpid(self._pid, 0)


class _Fork:
    """A side process that the nursery has forked.

    Its channel gives the exit code. When the channel closes without one, the nursery is gone, and
    the kernel has killed the process.
    """

    def __init__(self, channel: socket.socket, pidfd: int) -> None:
        self._channel, self._pidfd = channel, pidfd
        self._code: int | None = None

    def poll(self) -> int | None:
        return self._look(0.0)

    def wait(self, timeout: float | None = None) -> int:
        code = self._look(timeout)
        if code is None:
            raise subprocess.TimeoutExpired("a side process", timeout or 0.0)
        return code

    def send_signal(self, sig: int) -> None:
        if self.poll() is None:
            with suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._pidfd, sig)

    def _look(self, timeout: float | None) -> int | None:
        if self._code is None and select.select([self._channel], [], [], timeout)[0]:
            self._code = int(self._channel.recv(PACKET_MAX) or -signal.SIGKILL)
            self._channel.close()
            os.close(self._pidfd)
        return self._code


class _Child(NamedTuple):
    """A side process, as the nursery sees it."""

    pid: int
    channel: socket.socket


def _be_nursery(control: socket.socket, parent: int) -> None:
    """Fork a side process for each request, until the main process ends."""
    # A signal to the whole group means the others; this process ends when its worker has ended.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, _DEFERRED)
    die_with_parent(parent)
    _forget_handlers()
    _let_go_of_all_but(control)
    show_as([*_INTERPRETER, "-m", __name__, str(parent)])
    children: dict[int, _Child] = {}  # by pidfd
    while True:
        for descriptor in select.select([control.fileno(), *children], [], [])[0]:
            if descriptor in children:
                _reap(children, descriptor)
            elif not _start_next(control, children, mask):
                return


def _forget_handlers() -> None:
    """Handle signals as a new interpreter does."""
    for number in signal.valid_signals():
        if callable(signal.getsignal(number)):
            interrupts = number == signal.SIGINT
            signal.signal(number, signal.default_int_handler if interrupts else signal.SIG_DFL)


def _let_go_of_all_but(control: socket.socket) -> None:
    """Keep no descriptor but the standard streams, without an input, and the socket."""
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for descriptor in map(int, os.listdir("/proc/self/fd")):
        if descriptor not in (0, 1, 2, control.fileno()):
            with suppress(OSError):  # what has listed them is closed already
                os.close(descriptor)


def _start_next(control: socket.socket, children: dict[int, _Child], mask: Iterable[int]) -> bool:
    """Fork what the next request wants; False if there is none, for the main process has ended."""
    request, descriptors, _, _ = socket.recv_fds(control, PACKET_MAX, 1)
    if not request:
        return False
    command: list[str] = json.loads(request)
    main = importlib.import_module(command[1]).main  # here: the next one has it already
    channel, parent = socket.socket(fileno=descriptors[0]), os.getpid()
    pid = os.fork()
    if pid == 0:
        die_with_parent(parent)
        for pidfd, other in children.items():
            os.close(pidfd)
            other.channel.close()
        control.close()
        channel.close()
        show_as([*_INTERPRETER, *_with_parent(command, parent)])
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        run_forked(lambda: main(str(parent), *command[2:]), _say_nothing)
    pidfd = os.pidfd_open(pid)
    children[pidfd] = _Child(pid, channel)
    try:
        socket.send_fds(channel, [b"started"], [pidfd])
    except OSError:  # nobody waits for it any more
        signal.pidfd_send_signal(pidfd, signal.SIGKILL)
    return True


def _reap(children: dict[int, _Child], pidfd: int) -> None:
    """Reap a side process that has ended, and tell how."""
    child = children.pop(pidfd)
    os.close(pidfd)
    code = os.waitstatus_to_exitcode(os.waitpid(child.pid, 0)[1])
    with child.channel, suppress(OSError):
        child.channel.send(str(code).encode())


def _with_parent(command: Sequence[str], parent: int) -> tuple[str, ...]:
    return (*command[:2], str(parent), *command[2:])


def _say_nothing(_: str) -> None:
    """Leave it at the traceback in the log."""
