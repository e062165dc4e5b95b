"""How a process is bound to its parent and to its share of the machine."""

import ctypes
import os
import resource
import signal
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

_PR_SET_PDEATHSIG = 1  # linux/prctl.h
_EX_SOFTWARE = 70  # sysexits.h
_ARG_START = 45  # index after the name: arg_start arg_end (proc(5), fields 48 and 49)
_GIB = 2**30
_libc = ctypes.CDLL(None, use_errno=True)


def die_with_parent(parent: int, number: signal.Signals = signal.SIGKILL) -> None:
    """Have the kernel send this process a signal as soon as `parent`, its parent, has ended."""
    _set_parent_death_signal(number)
    if os.getppid() != parent:  # it ended before the call
        os._exit(1)


def outlive_parent() -> None:
    """Take back `die_with_parent`."""
    _set_parent_death_signal(0)


def _set_parent_death_signal(number: int) -> None:
    if _libc.prctl(_PR_SET_PDEATHSIG, number, 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), "prctl(PR_SET_PDEATHSIG)")


def limit_simulator(cpu_s: int) -> None:
    """Bound the resources of a simulator child, so that a fault of the platform costs one run.

    The box's own limits are lower and set by the sandbox.
    """
    for limit, value in (
        (resource.RLIMIT_CORE, 1),  # not 0, as for its boxes (sandbox/isolation/argument_rules.py)
        (resource.RLIMIT_NOFILE, 256),
        (resource.RLIMIT_DATA, 4 * _GIB),
        (resource.RLIMIT_AS, 16 * _GIB),  # LLVM and numpy reserve much more than they use
        (resource.RLIMIT_CPU, cpu_s),
    ):
        _, hard = resource.getrlimit(limit)
        bound = value if hard == resource.RLIM_INFINITY else min(value, hard)
        resource.setrlimit(limit, (bound, bound))


def pin(core: int | None) -> None:
    """Keep this process and its children on one core: in lock step a second one only costs time."""
    if core is not None:
        os.sched_setaffinity(0, {core})


def show_as(command: Sequence[str]) -> None:
    """Have `ps` list this process, a fork, with a command of its own, as far as there is room.

    The kernel shows what stands where it has put the arguments of the process.
    """
    fields = Path("/proc/self/stat").read_text().rpartition(")")[2].split()
    start, end = map(int, fields[_ARG_START : _ARG_START + 2])
    text = b"\0".join(os.fsencode(argument) for argument in command)[: end - start - 1]
    ctypes.memmove(start, text.ljust(end - start, b"\0"), end - start)


def run_forked(body: Callable[[], None], report_crash: Callable[[str], None]) -> NoReturn:
    """Be a forked process that does `body` and ends; `report_crash` gets its traceback, if any.

    Whatever happens, the code of the parent must not run a second time in the fork.
    """
    status = _EX_SOFTWARE
    try:
        body()
        status = 0
    except SystemExit:
        status = 0
    finally:
        try:
            if status:
                report_crash(traceback.format_exc())
                traceback.print_exc()
        finally:
            try:
                sys.stderr.flush()  # fails on a full disk
            finally:
                os._exit(status)


@dataclass(slots=True)
class RestartBackoff:
    """How long to wait before a process that died is started again."""

    first_s: float = 0.5
    longest_s: float = 30.0
    steady_s: float = 60.0  # a process that lived this long has recovered
    deaths: int = 0  # in a row

    def note_life(self, lived_s: float) -> None:
        """Forget earlier deaths if the process has lived long enough."""
        if lived_s >= self.steady_s:
            self.deaths = 0

    def next_wait_s(self) -> float:
        """Count a death and return the time to wait before the next start [s]."""
        wait_s = min(self.first_s * 2.0**self.deaths, self.longest_s)
        self.deaths += 1
        return wait_s


def exit_reason(code: int) -> str:
    """Return how a process ended, in words; `code` is negative for a signal, as in subprocess."""
    return f"exit code {code}" if code >= 0 else signal.Signals(-code).name
