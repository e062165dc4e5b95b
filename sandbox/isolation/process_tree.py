"""The process tree of one box: started isolated, monitored, killed to the last process.

A box may be used by a fork of the process that started it, therefore everything goes by descriptor.
The parent has to live as long as the box, since bubblewrap dies with it, and to close it too: only
the parent can reap.
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
from seamark.sandbox.isolation.bwrap_status import BwrapStatus
from seamark.sandbox.isolation.cgroups import ControlGroup
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.shared_images import SharedImages
from seamark.sandbox.isolation.uid_slots import UidSlot
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.runtime import Runtime

END_WITHIN_S = 5.0  # [s] measured 1-7 ms; a busy host may take longer
OUTPUT_BYTES = 1 << 20  # [B] capacity of the output pipe: a program that fills it blocks
RECEIVE_TIMEOUT_US = 20_000  # [us] an answer within this time costs one system call
START_WITHIN_S = 2.0  # [s] until bubblewrap reports the pid of its inner init
KILLED = 128 + signal.SIGKILL  # if bubblewrap died before it reported the program's exit code


@dataclass(frozen=True, slots=True, kw_only=True)
class Layers:
    """Which layers of isolation are switched on. Only tests use anything but `of`."""

    cgroups: bool
    own_uid: bool
    seccomp: bool = True
    namespaces: tuple[str, ...] = NAMESPACES

    @classmethod
    def of(cls, isolation: IsolationLevel) -> Self:
        """Return the layers of an isolation level; SandboxBroken if uploads may not run at it."""
        if isolation < IsolationLevel.MEDIUM:
            raise SandboxBroken("this host cannot isolate programs: see `seamark doctor`")
        if not seccomp.supported():
            raise SandboxBroken(f"the system call filter supports {seccomp.MACHINE} only")
        return cls(cgroups=isolation is IsolationLevel.STRONG, own_uid=os.geteuid() == 0)


class ProcessTree:
    """All processes of one box, with our ends of the descriptors."""

    def __init__(
        self, runtime: Runtime, limits: Limits, layers: Layers, *, core: int | None
    ) -> None:
        self.images: SharedImages | None = None
        self.pidfd = self.output = -1
        self._cgroup: ControlGroup | None = None
        self._status = BwrapStatus(-1)
        self._uid_slot: UidSlot | None = None
        self._init_pid = 0
        self._init_pidfd = -1
        self._cpu_s = self._memory_mib = 0.0
        self._seen: list[int] = []  # processes at the last reading of the CPU time
        self._parent = os.getpid()
        self.socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        # The kernel limits each wait: one system call is enough for an answer that comes soon.
        timeout = struct.pack("@ll", 0, RECEIVE_TIMEOUT_US)
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
        self._cgroup = ControlGroup(limits) if layers.cgroups else None
        self._uid_slot = UidSlot() if layers.own_uid else None
        self.output, stdout = _pipe(opened)
        with contextlib.suppress(OSError):  # a user's total is limited
            fcntl.fcntl(self.output, fcntl.F_SETPIPE_SZ, OUTPUT_BYTES)
        reported, status = _pipe(opened)
        self._status = BwrapStatus(reported)
        seccomp_filter = _filter(opened) if layers.seccomp else None
        self.images = SharedImages() if runtime.images else None
        images = self.images.descriptor if self.images else None
        descriptors = Descriptors(protocol, status, seccomp_filter, images)
        command = launcher_command(
            bwrap_command(
                runtime,
                limits,
                descriptors.inside(),
                limit_inside=self._cgroup is None,
                namespaces=layers.namespaces,
            ),
            limits,
            descriptors.inherited(),
            cgroups=self._cgroup.procs_files() if self._cgroup else [],
            uid=self._uid_slot.uid if self._uid_slot else None,
            core=core,
        )
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=stdout,
            stderr=stdout,
            pass_fds=descriptors.inherited(),
            env={},
            cwd="/",
        )
        self.pidfd = os.pidfd_open(self._process.pid)

    def find_init(self, within_s: float = 0.0) -> None:
        """Find the inner init process, if bubblewrap has reported its pid by now."""
        if self._init_pidfd >= 0:
            return
        pid = self._status.init_pid(within_s)
        if pid is None:
            return
        with contextlib.suppress(ProcessLookupError):
            descriptor = os.pidfd_open(pid)
            # The pid may have been reused meanwhile: accept our own child only.
            if proc_stats.parent_of(pid) == self._process.pid:
                self._init_pid, self._init_pidfd = pid, descriptor
            else:
                os.close(descriptor)

    def processes(self) -> list[int]:
        """Return the pids of all processes in the box, its init first."""
        return proc_stats.tree(self._init_pid) if self._init_pid else []

    def interrupt(self) -> None:
        """Send SIGUSR1 to all processes but the init: runners say where their program is."""
        opened = {pid: _opened(pid) for pid in self.processes()[1:]}
        living = set(self.processes())  # read again: before it was opened, a pid may be reused
        for pid, pidfd in opened.items():
            if pidfd is not None and pid in living:
                with contextlib.suppress(ProcessLookupError):
                    signal.pidfd_send_signal(pidfd, signal.SIGUSR1)
            if pidfd is not None:
                os.close(pidfd)

    def cpu_s(self) -> float:
        """Return the CPU time of all processes so far [s]."""
        if self._cgroup is not None:
            return self._cgroup.cpu_s()
        self._seen = self.processes()
        now = proc_stats.cpu_s(self._seen)
        self._cpu_s = max(self._cpu_s, now)  # a process that ended is no longer counted
        return self._cpu_s

    def memory_mib(self) -> float:
        """Return the peak of memory [MiB], as far as it can be known."""
        if self._cgroup is not None:
            return self._cgroup.memory_mib()
        now = proc_stats.memory_mib(self._init_pid) if self._init_pid else 0.0
        self._memory_mib = max(self._memory_mib, now)
        return self._memory_mib

    def run_queue_waits_s(self) -> dict[int, float]:
        """Return thread -> how long it has waited for a core [s], as of the last `cpu_s`."""
        if self._cgroup is not None:
            return proc_stats.run_queue_waits_s(self._cgroup.threads())
        return proc_stats.run_queue_waits_s(proc_stats.threads(self._seen))

    @property
    def cpu_every_s(self) -> float:
        """Return the shortest time between readings of CPU time [s]: slow without a cgroup."""
        return 0.02 if self._cgroup is not None else 0.2

    def out_of_memory(self) -> bool:
        """Return whether the kernel killed a process at the memory limit of the box."""
        return self._cgroup is not None and self._cgroup.out_of_memory()

    def host_out_of_memory(self) -> bool:
        """Return whether the kernel killed a process because the host was out of memory."""
        return self._cgroup is not None and self._cgroup.host_out_of_memory()

    def out_of_processes(self) -> bool:
        """Return whether the kernel refused to start a process."""
        return self._cgroup is not None and self._cgroup.out_of_processes()

    def exit_code(self, within_s: float) -> int | None:
        """Return the program's exit code (128 + signal if by one); None if it still runs."""
        if not _readable(self.pidfd, within_s):
            return None
        reported = self._status.exit_code()
        ended = self._reaped()
        return ended if reported is None else reported

    def _reaped(self) -> int:
        """Return bubblewrap's own exit code; it has ended."""
        if os.getpid() != self._parent:  # only the parent may wait for it
            self._process.returncode = KILLED
            return KILLED
        code = self._process.wait()
        return code if code >= 0 else KILLED

    def set_affinity(self, cores: set[int]) -> None:
        """Let all processes of a box without a program run on these cores."""
        if not self._init_pid or os.sched_getaffinity(self._init_pid) == cores:
            return
        # The group knows its threads at once; without one, all processes of the host are looked at.
        within = self.processes() if self._cgroup is None else self._cgroup.threads()
        for thread in within:
            # Without permission it is slower, not wrong; a thread that ended is noticed later.
            with contextlib.suppress(PermissionError, ProcessLookupError):
                os.sched_setaffinity(thread, cores)

    def kill(self) -> None:
        """Kill every process and wait for the kernel; SandboxBroken if one survives.

        The inner init is killed first: the kernel then kills its whole pid namespace, and the outer
        bubblewrap reaps it. Killing the outer one leaves the rest running for some milliseconds.
        """
        if self.exit_code(0) is None:
            self.find_init(START_WITHIN_S)
            _kill(self._init_pidfd if self._init_pidfd >= 0 else self.pidfd)
        if self._cgroup is not None:
            self._cgroup.kill()
        if self.exit_code(END_WITHIN_S) is None:
            _kill(self.pidfd)
            if self.exit_code(END_WITHIN_S) is None:
                raise SandboxBroken("the box cannot be killed")

    def hand_over(self) -> None:
        """Close our end of the communication: a fork of this process uses it now."""
        self.socket.close()
        if self.images is not None:
            self.images.close()
        self._close("output")

    def detach(self) -> None:
        """Close everything without killing anything: others use the box."""
        self._process.returncode = KILLED  # this process does not wait for it
        self.hand_over()
        self._status.close()
        self._close("pidfd", "_init_pidfd")
        if self._cgroup is not None:
            self._cgroup.detach()
        if self._uid_slot is not None:
            self._uid_slot.release()

    def _close(self, *names: str) -> None:
        for name in names:
            if getattr(self, name) >= 0:
                os.close(getattr(self, name))
                setattr(self, name, -1)

    def release(self) -> None:
        """Close what is open and remove the cgroup, which proves that nothing survives."""
        self.hand_over()
        self._status.close()
        self._close("pidfd", "_init_pidfd")
        try:
            if self._cgroup is not None:
                self._cgroup.remove()
                self._cgroup = None
        finally:
            if self._uid_slot is not None:
                self._uid_slot.release()


def _pipe(opened: contextlib.ExitStack) -> tuple[int, int]:
    """Return a pipe; `opened` closes its writing end, which the box inherits."""
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


def _opened(pid: int) -> int | None:
    try:
        return os.pidfd_open(pid)
    except ProcessLookupError:
        return None


def _kill(pidfd: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        signal.pidfd_send_signal(pidfd, signal.SIGKILL)


def _readable(descriptor: int, within_s: float) -> bool:
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    return bool(poll.poll(within_s * 1000))
