"""The processes of one box: started confined, watched, killed to the last one.

A box may be used by a fork of the process that made it: everything goes by descriptors. The maker
has to live as long, since bubblewrap dies with it, and to close the box too: only it can reap.
"""

import contextlib
import fcntl
import os
import select
import signal
import socket
import struct
import subprocess
from dataclasses import dataclass
from typing import Self

from seamark.sandbox.isolation import proc_stats, seccomp
from seamark.sandbox.isolation.bwrap_command import (
    NAMESPACES,
    Descriptors,
    bwrap_command,
    launcher_command,
)
from seamark.sandbox.isolation.bwrap_status import Information
from seamark.sandbox.isolation.cgroups import ControlGroup
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.shared_images import Pictures
from seamark.sandbox.isolation.uid_slots import Slot
from seamark.sandbox.languages.language import Runtime
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import SandboxBroken

END_WITHIN_S = 5.0  # [s] measured 1-7 ms; a busy host may take longer
OUTPUT_BYTES = 1 << 20  # [B] what a program may print before it has to wait until we read
QUICK_US = 20_000  # [us] an answer that comes within it costs one system call
START_WITHIN_S = 2.0  # [s] until bubblewrap tells the pid of its inner init
KILLED = 128 + signal.SIGKILL  # the exit code of a bubblewrap that could not tell the program's


@dataclass(frozen=True, slots=True, kw_only=True)
class Layers:
    """What is switched on. Only tests and `doctor` choose anything but `of`."""

    groups: bool
    own_uid: bool
    seccomp: bool = True
    namespaces: tuple[str, ...] = NAMESPACES

    @classmethod
    def of(cls, isolation: IsolationLevel) -> Self:
        """Return the layers of a level; SandboxBroken if uploads may not run at it."""
        if isolation < IsolationLevel.MEDIUM:
            raise SandboxBroken("this host cannot isolate programs: see `seamark doctor`")
        if not seccomp.supported():
            raise SandboxBroken(f"the system call filter is for {seccomp.MACHINE} alone")
        return cls(groups=isolation is IsolationLevel.STRONG, own_uid=os.geteuid() == 0)


class Confined:
    """All processes of one box, with the descriptors by which the trusted side meets them."""

    def __init__(
        self, runtime: Runtime, limits: Limits, layers: Layers, *, core: int | None
    ) -> None:
        self.group: ControlGroup | None = None
        self.pidfd = self.output = -1
        self._information = Information(-1)
        self._slot: Slot | None = None
        self.pictures: Pictures | None = None
        self._init_pid = 0
        self._init_pidfd = -1
        self._cpu_s = self._memory_mib = 0.0
        self._maker = os.getpid()
        self.socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        # Waiting is cut into slices by the kernel: one system call for an answer that comes soon.
        timeout = struct.pack("@ll", 0, QUICK_US)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, timeout)
        try:
            with theirs, contextlib.ExitStack() as opened:
                self._start(runtime, limits, layers, core, theirs.fileno(), opened)
        except (OSError, SandboxBroken) as error:
            self.release()
            raise SandboxBroken(f"the box did not start: {error}") from error

    def _start(
        self,
        runtime: Runtime,
        limits: Limits,
        layers: Layers,
        core: int | None,
        protocol: int,
        opened: contextlib.ExitStack,
    ) -> None:
        self.group = ControlGroup(limits) if layers.groups else None
        self._slot = Slot() if layers.own_uid else None
        self.output, printing = _pipe(opened)
        with contextlib.suppress(OSError):  # a user may have only so much of it
            fcntl.fcntl(self.output, fcntl.F_SETPIPE_SZ, OUTPUT_BYTES)
        telling, informing = _pipe(opened)
        self._information = Information(telling)
        filters = _filter(opened) if layers.seccomp else None
        self.pictures = Pictures() if runtime.images else None
        images = self.pictures.descriptor if self.pictures else None
        use = Descriptors(protocol, informing, filters, images)
        command = launcher_command(
            bwrap_command(
                runtime,
                limits,
                use.inside(),
                limit_inside=self.group is None,
                namespaces=layers.namespaces,
            ),
            limits,
            use.inherited(),
            groups=self.group.entries() if self.group else [],
            uid=self._slot.uid if self._slot else None,
            core=core,
        )
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=printing,
            stderr=printing,
            pass_fds=use.inherited(),
            env={},
            cwd="/",
        )
        self.pidfd = os.pidfd_open(self._process.pid)

    def meet_init(self, within_s: float = 0.0) -> None:
        """Learn which process is the inner init, if bubblewrap has told it by now."""
        if self._init_pidfd >= 0:
            return
        pid = self._information.init_pid(within_s)
        if pid is None:
            return
        with contextlib.suppress(ProcessLookupError):
            descriptor = os.pidfd_open(pid)
            # A number may have been given to somebody else meanwhile: only our own child counts.
            if proc_stats.parent_of(pid) == self._process.pid:
                self._init_pid, self._init_pidfd = pid, descriptor
            else:
                os.close(descriptor)

    def processes(self) -> list[int]:
        """Return the pids of all processes in the box, its init first."""
        return proc_stats.tree(self._init_pid) if self._init_pid else []

    def cpu_s(self) -> float:
        """Return the CPU time of all processes so far [s]."""
        if self.group is not None:
            return self.group.cpu_s()
        now = proc_stats.cpu_s(self._init_pid) if self._init_pid else 0.0
        self._cpu_s = max(self._cpu_s, now)  # a tree that ended counts nothing any more
        return self._cpu_s

    def memory_mib(self) -> float:
        """Return the peak of memory [MiB], as far as it can be known."""
        if self.group is not None:
            return self.group.memory_mib()
        now = proc_stats.memory_mib(self._init_pid) if self._init_pid else 0.0
        self._memory_mib = max(self._memory_mib, now)
        return self._memory_mib

    @property
    def cpu_every_s(self) -> float:
        """Return how often the CPU time should be read at most: without groups it is slow [s]."""
        return 0.02 if self.group is not None else 0.2

    def out_of_memory(self) -> bool:
        """Tell whether the kernel ended a process for the memory of the box."""
        return self.group is not None and self.group.out_of_memory()

    def host_out_of_memory(self) -> bool:
        """Tell whether the kernel ended a process for memory that others have."""
        return self.group is not None and self.group.host_out_of_memory()

    def out_of_processes(self) -> bool:
        """Tell whether the kernel refused a process."""
        return self.group is not None and self.group.out_of_processes()

    def exit_code(self, within_s: float) -> int | None:
        """Return how the program ended (128 + signal if by one); None if it still lives."""
        if not _readable(self.pidfd, within_s):
            return None
        told = self._information.exit_code()
        ended = self._reaped()
        return ended if told is None else told

    def _reaped(self) -> int:
        """Return bubblewrap's own exit code; it has ended."""
        if os.getpid() != self._maker:  # only its parent may wait for it
            self._process.returncode = KILLED
            return KILLED
        code = self._process.wait()
        return code if code >= 0 else KILLED

    def move(self, cores: set[int]) -> None:
        """Let all processes run on these cores; of a box that has no program yet."""
        if not self._init_pid or os.sched_getaffinity(self._init_pid) == cores:
            return
        for pid in self.processes():
            # Where we may not, it is slower and not wrong; one that ended is seen later.
            with contextlib.suppress(PermissionError, ProcessLookupError):
                os.sched_setaffinity(pid, cores)

    def kill(self) -> None:
        """Kill every process and wait until the kernel is done; SandboxBroken if it is not.

        The inner init goes first: with it the kernel ends the whole pid namespace, and bubblewrap
        outside reaps it. Killing the outer one leaves the others running for some milliseconds.
        """
        if self.exit_code(0) is None:
            self.meet_init(START_WITHIN_S)
            _kill(self._init_pidfd if self._init_pidfd >= 0 else self.pidfd)
        if self.group is not None:
            self.group.kill()
        if self.exit_code(END_WITHIN_S) is None:
            _kill(self.pidfd)
            if self.exit_code(END_WITHIN_S) is None:
                raise SandboxBroken("the box cannot be killed")

    def leave(self) -> None:
        """Close all by which one talks to the program: a fork of this process does that now."""
        self.socket.close()
        if self.pictures is not None:
            self.pictures.close()
        self._close("output")

    def forget(self) -> None:
        """Close everything, and end nothing: the box is used by others."""
        self._process.returncode = KILLED  # it is not waited for in here
        self.leave()
        self._information.close()
        self._close("pidfd", "_init_pidfd")
        if self.group is not None:
            self.group.forget()
        if self._slot is not None:
            self._slot.release()

    def _close(self, *names: str) -> None:
        for name in names:
            if getattr(self, name) >= 0:
                os.close(getattr(self, name))
                setattr(self, name, -1)

    def release(self) -> None:
        """Close what is open and remove the groups, which proves that nothing survives."""
        self.leave()
        self._information.close()
        self._close("pidfd", "_init_pidfd")
        try:
            if self.group is not None:
                self.group.remove()
                self.group = None
        finally:
            if self._slot is not None:
                self._slot.release()


def _pipe(opened: contextlib.ExitStack) -> tuple[int, int]:
    """Return a pipe; its writing end is closed here as soon as the box has it."""
    reading, writing = os.pipe2(os.O_CLOEXEC)
    opened.callback(os.close, writing)
    os.set_blocking(reading, False)
    return reading, writing


def _filter(opened: contextlib.ExitStack) -> int:
    """Return a descriptor from which bubblewrap reads the system call filter."""
    descriptor = os.memfd_create("filter", os.MFD_CLOEXEC)
    opened.callback(os.close, descriptor)
    os.write(descriptor, seccomp.build())
    os.lseek(descriptor, 0, os.SEEK_SET)
    return descriptor


def _kill(pidfd: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        signal.pidfd_send_signal(pidfd, signal.SIGKILL)


def _readable(descriptor: int, within_s: float) -> bool:
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    return bool(poll.poll(within_s * 1000))
