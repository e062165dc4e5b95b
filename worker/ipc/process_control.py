"""What binds a process to its parent and to its share of the machine."""

import ctypes
import os
import resource
import signal

_PR_SET_PDEATHSIG = 1  # linux/prctl.h
_GIB = 2**30
_libc = ctypes.CDLL(None, use_errno=True)


def die_with_parent(parent: int) -> None:
    """Have the kernel kill this process when `parent`, its parent, ends in whatever way."""
    if _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), "prctl(PR_SET_PDEATHSIG)")
    if os.getppid() != parent:  # it ended before the call
        os._exit(1)


def limit_simulator(cpu_s: int) -> None:
    """Bound what a simulator child may take, so that a fault of ours costs one run, not the host.

    The box's own limits are lower and set by the sandbox.
    """
    for what, most in (
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NOFILE, 256),
        (resource.RLIMIT_DATA, 4 * _GIB),
        (resource.RLIMIT_AS, 16 * _GIB),  # LLVM and numpy reserve much more than they use
        (resource.RLIMIT_CPU, cpu_s),
    ):
        _, hard = resource.getrlimit(what)
        bound = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(what, (bound, bound))


def pin(core: int | None) -> None:
    """Keep this process and its children on one core: in lock step a second one only costs time."""
    if core is not None:
        os.sched_setaffinity(0, {core})
