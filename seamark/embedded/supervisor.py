"""Keeps child processes running, and at the end stops them with everything they started.

One thread, no signal handlers: SIGCHLD, SIGINT and SIGTERM are blocked and received by
`sigtimedwait`, so that none is lost and none interrupts anything.
"""

from __future__ import annotations

import contextlib
import ctypes
import math
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from seamark.sandbox.isolation.proc_stats import parent_of, tree
from seamark.worker.ipc.process_control import RestartBackoff, die_with_parent, exit_reason

PR_SET_CHILD_SUBREAPER = 36  # linux/prctl.h
STOP_SIGNALS = frozenset({signal.SIGINT, signal.SIGTERM, signal.SIGHUP})
WATCHED = STOP_SIGNALS | {signal.SIGCHLD}
LOG_KEPT_BYTES = 8 * 1024 * 1024  # a larger log is rotated; one older is kept

_libc = ctypes.CDLL(None, use_errno=True)


@dataclass(slots=True)
class Child:
    """One process to keep alive.

    `stop_order` 0 ends first; children with the same number end together.
    """

    name: str
    argv: Sequence[str]
    environ: Mapping[str, str]
    log: Path
    stop_order: int = 0
    grace_s: float = 10.0
    process: subprocess.Popen[bytes] | None = None
    started_at: float = 0.0
    backoff: RestartBackoff = field(default_factory=RestartBackoff)
    due_at: float | None = None
    exits: list[int] = field(default_factory=list)
    kill_at: float | None = None  # of one that was asked to end for good


def _open_log(path: Path) -> IO[bytes]:
    path.parent.mkdir(parents=True, exist_ok=True)
    return path.open("ab")


def _rotate(path: Path) -> None:
    """Keep a large log as the older one, and go on with an empty file.

    By a copy, since the child has the file open; it appends, so that it goes on at the new end.
    """
    with contextlib.suppress(OSError):
        if path.stat().st_size > LOG_KEPT_BYTES:
            shutil.copyfile(path, path.with_suffix(".log.1"))
            os.truncate(path, 0)


def _bind_to_parent(parent: int) -> Callable[[], None]:
    """Return what runs in the child between fork and exec: it dies with its parent."""

    def prepare() -> None:
        die_with_parent(parent, signal.SIGTERM)
        signal.pthread_sigmask(signal.SIG_SETMASK, ())

    return prepare


class Supervisor:
    """Starts children, restarts those that die after a back-off, and stops all of them in order.

    Parameters
    ----------
    say
        Prints one line for the person at the terminal.
    """

    def __init__(self, say: Callable[[str], None]) -> None:
        self.children: list[Child] = []
        self._say = say

    def __enter__(self) -> Supervisor:
        """Take over the signals, and the orphans of the children."""
        self._old_mask = signal.pthread_sigmask(signal.SIG_BLOCK, WATCHED)
        # Orphans of a killed child become ours instead of init's, so that they can be stopped too.
        _libc.prctl(PR_SET_CHILD_SUBREAPER, 1)
        return self

    def __exit__(self, *_: object) -> None:
        """Stop everything and restore the signal mask."""
        self.stop()
        _libc.prctl(PR_SET_CHILD_SUBREAPER, 0)
        signal.pthread_sigmask(signal.SIG_SETMASK, self._old_mask)

    def add(self, child: Child) -> Child:
        """Start one more child and return it."""
        self.children.append(child)
        self._start(child)
        return child

    def retire(self, child: Child) -> None:
        """Ask a child to end for good; returns at once, and forgets it when it has ended."""
        if child.process is None:
            self.children.remove(child)
        elif child.kill_at is None:
            child.process.send_signal(signal.SIGTERM)
            child.kill_at = time.monotonic() + child.grace_s

    def _start(self, child: Child) -> None:
        with _open_log(child.log) as log:
            child.process = subprocess.Popen(
                child.argv,
                env=dict(child.environ),
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # Ctrl-C reaches only us; we stop them in order
                preexec_fn=_bind_to_parent(os.getpid()),  # noqa: PLW1509 (one thread only)
            )
        child.started_at = time.monotonic()
        child.due_at = None

    def wait(self, timeout_s: float) -> signal.Signals | None:
        """Wait for at most `timeout_s`; return the stop signal if one came."""
        deadline = time.monotonic() + timeout_s
        while True:
            wait_s = min([deadline, *self._due_at()]) - time.monotonic()
            seen = signal.sigtimedwait(WATCHED, max(wait_s, 0.0))
            if seen is not None and signal.Signals(seen.si_signo) in STOP_SIGNALS:
                return signal.Signals(seen.si_signo)
            self._kill_overdue()
            self._reap()
            self._restart_due()
            for child in self.children:
                _rotate(child.log)
            if seen is None and time.monotonic() >= deadline:
                return None

    def _due_at(self) -> Iterator[float]:
        """Yield when children are to be started or killed (monotonic)."""
        for child in self.children:
            for at in (child.due_at, child.kill_at):
                if at is not None:
                    yield at

    def _reap(self) -> None:
        """Note which children are dead, and reap the dead orphans that became ours."""
        running = {child.process.pid: child for child in self.children if child.process is not None}
        while (pid := _dead_child()) is not None:
            if pid in running:
                self._note_death(running.pop(pid))
            else:
                os.waitpid(pid, 0)

    def _note_death(self, child: Child) -> None:
        process = child.process
        if process is None or process.poll() is None:
            return
        now = time.monotonic()
        if child.kill_at is not None:
            child.process = None
            self.children.remove(child)
            self._kill_session(process.pid)
            return
        child.backoff.note_life(now - child.started_at)
        wait_s = child.backoff.next_wait_s()
        child.exits.append(process.returncode)
        child.process = None
        child.due_at = now + wait_s
        self._kill_session(process.pid)  # what it leaves behind must not run beside its successor
        self._say(
            f"{child.name} ended ({exit_reason(process.returncode)}); "
            f"it restarts in {wait_s:g} s. See {child.log}"
        )

    def _kill_overdue(self) -> None:
        now = time.monotonic()
        for child in self.children:
            if child.kill_at is not None and child.kill_at <= now and child.process is not None:
                child.process.kill()
                child.kill_at = math.inf  # once: its end is told by the kernel

    def _restart_due(self) -> None:
        now = time.monotonic()
        for child in self.children:
            if child.due_at is not None and child.due_at <= now:
                self._start(child)

    def stop(self) -> None:
        """Stop all children in order, then kill what they left behind."""
        for child in self.children:
            child.due_at = None
        for order in sorted({child.stop_order for child in self.children}):
            self._stop_together([child for child in self.children if child.stop_order == order])
        self._kill_leftovers()
        self.children.clear()

    def _stop_together(self, children: Sequence[Child]) -> None:
        living = [(c, c.process) for c in children if c.process is not None]
        for _, process in living:
            process.send_signal(signal.SIGTERM)
        for child, process in living:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._wait_for(process, child.grace_s)
            self._kill_session(process.pid)
            process.wait()
            child.process = None

    def _wait_for(self, process: subprocess.Popen[bytes], grace_s: float) -> None:
        """Wait until the process has ended; a second Ctrl-C ends the wait."""
        deadline = time.monotonic() + grace_s
        while process.poll() is None:
            left = deadline - time.monotonic()
            seen = signal.sigtimedwait(WATCHED, max(left, 0.0))
            impatient = seen is not None and seen.si_signo == signal.SIGINT
            if left <= 0 or impatient:
                raise subprocess.TimeoutExpired(process.args, grace_s)

    @staticmethod
    def _kill_session(leader: int) -> None:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(leader, signal.SIGKILL)

    @staticmethod
    def _kill_leftovers() -> None:
        # The children of those killed become ours, and are killed in the next round.
        while pids := _child_pids():
            for pid in pids:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
                with contextlib.suppress(ChildProcessError):
                    os.waitpid(pid, 0)


def _dead_child() -> int | None:
    """Return a child that is dead and not reaped yet; None if all live, or there is none."""
    try:
        # The kernel has a list of them, where a look at all processes of the machine takes long.
        dead = os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return None
    return None if dead is None else dead.si_pid


def _child_pids() -> list[int]:
    mine = os.getpid()
    return [pid for pid in tree(mine) if parent_of(pid) == mine]
