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
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import Self

import structlog

from seamark.sandbox.isolation import proc_stats
from seamark.worker.ipc.fork_server import (
    DEFERRED,
    ForkedProcess,
    ForkServer,
    Process,
    ask,
    say_nothing,
)
from seamark.worker.ipc.process_control import die_with_parent, run_forked, show_as

ANSWER_S = 30.0  # [s] in which the nursery has loaded a module, even on a busy machine
_INTERPRETER = (sys.executable, "-s", "-P")
_log = structlog.get_logger()


def spawn(command: Sequence[str], *, kept: Sequence[int] = ()) -> Process:
    """Start a side process in a new interpreter.

    Parameters
    ----------
    command
        `-m`, a module and its arguments after the first one, which is this process.
    kept
        The descriptors that it gets beside the standard streams, with the same numbers.
    """
    whole = _INTERPRETER + _with_parent(command, os.getpid())
    return subprocess.Popen(whole, stdin=subprocess.DEVNULL, pass_fds=kept)


class Nursery:
    """The nursery, as the main process of its worker sees it."""

    def __init__(self, pid: int, control: socket.socket, kept: Sequence[int]) -> None:
        self._pid, self._control, self._kept = pid, control, kept

    @classmethod
    def fork(cls, *, kept: Sequence[int] = ()) -> Self | None:
        """Fork a nursery; None if this process has other threads: a fork keeps their locks.

        Side processes get the descriptors in `kept` as `spawn` gives them.
        """
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
                run_forked(lambda: _be_nursery(theirs, parent, kept), say_nothing)
        return cls(pid, control, kept)

    def start(self, command: Sequence[str]) -> Process:
        """Start a side process, as `spawn` does; in a new interpreter if the nursery is gone."""
        if self._control.fileno() >= 0:
            try:
                return self._ask_for(command)
            except OSError as error:
                _log.warning("nursery_gone", why=str(error))
                self.close()
        return spawn(command, kept=self._kept)

    def _ask_for(self, command: Sequence[str]) -> ForkedProcess:
        process = ask(self._control, json.dumps(command).encode())
        if not process.started(ANSWER_S):
            process.send_signal(signal.SIGKILL)
            raise ConnectionResetError("it has ended, or hangs")
        return process

    def close(self) -> None:
        """End the nursery, and with it the side processes that it has forked."""
        self._control.close()
        with suppress(ProcessLookupError, ChildProcessError):
            os.kill(self._pid, signal.SIGKILL)
            os.waitpid(self._pid, 0)


def _be_nursery(control: socket.socket, parent: int, kept: Sequence[int]) -> None:
    """Fork a side process for each request, until the main process ends."""
    # A signal to the whole group means the others; this process ends when its worker has ended.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, DEFERRED)
    die_with_parent(parent)
    _forget_handlers()
    _let_go_of_all_but(control.fileno(), *kept)
    show_as([*_INTERPRETER, "-m", __name__, str(parent)])
    ForkServer(control, _begin, mask=mask).serve()


def _forget_handlers() -> None:
    """Handle signals as a new interpreter does."""
    for number in signal.valid_signals():
        if callable(signal.getsignal(number)):
            interrupts = number == signal.SIGINT
            signal.signal(number, signal.default_int_handler if interrupts else signal.SIG_DFL)


def _let_go_of_all_but(*kept: int) -> None:
    """Keep no other descriptor but the standard streams, without an input."""
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for descriptor in map(int, os.listdir("/proc/self/fd")):
        if descriptor not in (0, 1, 2, *kept):
            with suppress(OSError):  # what has listed them is closed already
                os.close(descriptor)


def _begin(request: bytes, _: list[int]) -> Callable[[], None]:
    """Load what a side process is, here: the next one has it already."""
    command: list[str] = json.loads(request)
    main = importlib.import_module(command[1]).main
    return partial(_be_side_process, main, _with_parent(command, os.getpid()))


def _be_side_process(main: Callable[..., None], command: tuple[str, ...]) -> None:
    show_as([*_INTERPRETER, *command])
    main(*command[2:])


def _with_parent(command: Sequence[str], parent: int) -> tuple[str, ...]:
    return (*command[:2], str(parent), *command[2:])
