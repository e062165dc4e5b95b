"""Control groups of a box: memory, processes and CPU time of all its processes together."""

import contextlib
import itertools
import os
import signal
import time
from pathlib import Path

from seamark.sandbox.isolation.cgroup_parents import CgroupPaths, parent_groups
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import SandboxBroken

PREFIX = "seamark-box-"
OVERHEAD_PROCESSES = 3  # the outer bwrap, the inner one, and one for the start
REMOVE_WITHIN_S = 5.0  # [s] the kernel ends 20 processes in 4 ms; a busy host takes longer
# All processes of a box together get half of the CPU time of one other process, so that boxes share
# equally and the service comes first: half of the default weight of a process (version 1) or of a
# group (version 2).
CPU_SHARES, CPU_WEIGHT = 512, 50
_serial = itertools.count()


def remove_orphans() -> int:
    """Kill and remove the boxes of killed workers; return how many groups were removed.

    bubblewrap dies with its worker, except during some milliseconds of its start: a worker killed
    then leaves an inner init that waits for its parent forever, without a program.
    """
    removed = 0
    for folder in reversed(parent_groups().folders()):  # unified first: it can kill all at once
        for group in folder.glob(PREFIX + "*"):
            owner = group.name.removeprefix(PREFIX).partition("-")[0]
            if not Path("/proc", owner).exists():
                _kill(group)
                removed += _removed(group)
    return removed


def _kill(group: Path) -> None:
    """Kill every process in a group, by the kernel or one by one."""
    with contextlib.suppress(OSError):
        if (group / "cgroup.kill").exists():
            (group / "cgroup.kill").write_text("1")
            return
        for pid in (group / "cgroup.procs").read_text().split():
            os.kill(int(pid), signal.SIGKILL)


class Kernel:
    """Creates and removes groups; tests of another cgroup version have a fake one."""

    create = staticmethod(Path.mkdir)
    remove = staticmethod(Path.rmdir)


class ControlGroup:
    """The groups of one box."""

    def __init__(
        self, limits: Limits, *, parents: CgroupPaths | None = None, kernel: type[Kernel] = Kernel
    ) -> None:
        """Create the groups; only tests pass `parents` other than those of this host."""
        if parents is None:
            remove_orphans()
        self.name = f"{PREFIX}{os.getpid()}-{next(_serial)}"
        self._kernel = kernel
        self._paths = (parents or parent_groups()).child(self.name)
        self._version = 2 if self._paths.memory == self._paths.unified else 1
        self._usage = -1
        try:
            for folder in self._paths.folders():
                kernel.create(folder)
            self._set_limits(limits)
            usage = "cpu.stat" if self._version == 2 else "cpuacct.usage"
            self._usage = os.open(self._paths.cpu_usage / usage, os.O_RDONLY | os.O_CLOEXEC)
        except OSError as error:
            self.remove()
            raise SandboxBroken(f"control group {self.name}: {error}") from error

    def _set_limits(self, limits: Limits) -> None:
        size = str(limits.memory_mib << 20)
        (self._paths.pids / "pids.max").write_text(str(limits.processes + OVERHEAD_PROCESSES))
        if self._version == 2:
            (self._paths.memory / "memory.max").write_text(size)
            # Kill the whole box: which process is the largest depends on the moment.
            (self._paths.memory / "memory.oom.group").write_text("1")
            swap = (self._paths.memory / "memory.swap.max", "0")
        else:
            (self._paths.memory / "memory.limit_in_bytes").write_text(size)
            swap = (self._paths.memory / "memory.memsw.limit_in_bytes", size)
        with contextlib.suppress(OSError):  # kernels without swap accounting have no such file
            swap[0].write_text(swap[1])
        self._share_cpu()

    def _share_cpu(self) -> None:
        """Give the box one share of the CPU time, whatever the number of its processes."""
        if self._paths.cpu_shares is None:
            return
        share = ("cpu.weight", CPU_WEIGHT) if self._version == 2 else ("cpu.shares", CPU_SHARES)
        with contextlib.suppress(OSError):  # another manager of groups may take the controller away
            (self._paths.cpu_shares / share[0]).write_text(str(share[1]))

    def procs_files(self) -> list[str]:
        """Return the files by which the launcher joins the groups."""
        return [f"{folder}/cgroup.procs" for folder in self._paths.folders()]

    def cpu_s(self) -> float:
        """Return the CPU time that all processes used so far [s]."""
        text = os.pread(self._usage, 64, 0)
        if self._version == 2:
            return int(text.split(None, 2)[1]) / 1e6  # first line: usage_usec N
        return int(text) / 1e9

    def threads(self) -> list[int]:
        """Return the ids of all threads in the group."""
        name = "cgroup.threads" if self._version == 2 else "tasks"
        try:
            return [*map(int, (self._paths.pids / name).read_text().split())]
        except OSError:
            return []

    def memory_mib(self) -> float:
        """Return the peak of memory [MiB]; 0 where the kernel does not keep it."""
        name = "memory.peak" if self._version == 2 else "memory.max_usage_in_bytes"
        try:
            return int((self._paths.memory / name).read_text()) / (1 << 20)
        except OSError:
            return 0.0

    def out_of_memory(self) -> bool:
        """Return whether the kernel killed a process at the memory limit of the box."""
        name = "memory.events" if self._version == 2 else "memory.oom_control"
        return _counter(self._paths.memory / name, "oom_kill") > 0 and not self.host_out_of_memory()

    def host_out_of_memory(self) -> bool:
        """Return whether a process was killed because the host, or a parent group, had no memory.

        `oom_kill` counts kills for any reason, `oom` how often the group's own limit was reached
        (cgroup-v2.rst). Version 1 has the first alone: there, each kill counts as the program's.
        """
        events = self._paths.memory / "memory.events"
        killed = self._version == 2 and _counter(events, "oom_kill") > 0
        return killed and _counter(events, "oom") == 0

    def out_of_processes(self) -> bool:
        """Return whether starting a process was refused."""
        return _counter(self._paths.pids / "pids.events", "max") > 0

    def kill(self) -> None:
        """Kill every process; one that was just entering the groups is not in all of them."""
        for folder in self._paths.folders():
            _kill(folder)

    def detach(self) -> None:
        """Close what is open and leave the groups to others; a second call does nothing."""
        if self._usage >= 0:
            os.close(self._usage)
            self._usage = -1

    def remove(self) -> None:
        """Remove the groups, which proves that no process is left; SandboxBroken if one is."""
        self.detach()
        deadline = time.monotonic() + REMOVE_WITHIN_S
        for folder in self._paths.folders():
            while not _removed(folder, self._kernel):
                if time.monotonic() > deadline:
                    raise SandboxBroken(f"processes survive in {folder}")
                self.kill()
                time.sleep(0.002)  # version 1 does not announce that a group is empty


def _removed(folder: Path, kernel: type[Kernel] = Kernel) -> bool:
    try:
        kernel.remove(folder)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    return True


def _counter(path: Path, name: str) -> int:
    try:
        pairs = (line.split() for line in path.read_text().splitlines())
        return next((int(value) for key, value in pairs if key == name), 0)
    except OSError:
        return 0
