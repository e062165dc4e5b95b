"""Control groups of a box: memory, processes and CPU time of all its processes together.

Works with cgroup version 1, version 2 and both mixed: it looks for controllers, not for a version.
Version 2 offers `cgroup.kill` even where it has no controllers.
"""

import contextlib
import itertools
import os
import signal
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import SandboxBroken

PREFIX = "seamark-box-"
LEAF = "seamark-service"  # the group of the service's own processes, beside its boxes
DELEGATED = "user.delegate"  # systemd sets it since version 251
REQUIRED = {"memory", "pids"}
MOVE_ATTEMPTS = 20  # processes may be started while others are moved
OVERHEAD_PROCESSES = 3  # the outer bwrap, the inner one, and one for the start
REMOVE_WITHIN_S = 5.0  # [s] the kernel ends 20 processes in 4 ms; a busy host takes longer
_serial = itertools.count()


@dataclass(frozen=True, slots=True)
class CgroupPaths:
    """Where groups are created. A version 2 hierarchy may hold all controllers or none."""

    memory: Path
    pids: Path
    cpu: Path
    unified: Path | None  # for cgroup.kill

    def folders(self) -> list[Path]:
        """Return each folder once."""
        every = {self.memory, self.pids, self.cpu, self.unified}
        return sorted(folder for folder in every if folder is not None)

    def child(self, name: str) -> "CgroupPaths":
        """Return the paths of a child group."""
        unified = self.unified / name if self.unified else None
        return CgroupPaths(self.memory / name, self.pids / name, self.cpu / name, unified)


PROC = Path("/proc/self")


@cache
def parent_groups(proc: Path = PROC) -> CgroupPaths:
    """Return the groups in which boxes get theirs; SandboxBroken with the reason if none."""
    mounts = _mounts(proc)
    own = _own_groups(proc)
    v1 = {
        name: _below(mounts[name], own.get(name, "/"))
        for name in ("memory", "pids", "cpuacct")
        if name in mounts
    }
    unified = _unified(mounts, own)
    if unified is not None and REQUIRED <= _controllers(unified):
        found = CgroupPaths(unified, unified, unified, unified)
    elif len(v1) == 3:
        found = CgroupPaths(v1["memory"], v1["pids"], v1["cpuacct"], unified)
    else:
        raise SandboxBroken("no control groups with the memory and pids controllers")
    for folder in {found.memory, found.pids, found.cpu}:
        if not os.access(folder, os.W_OK):
            raise SandboxBroken(f"no permission to create control groups in {folder}")
    return found


def _mounts(proc: Path) -> dict[str, tuple[Path, str]]:
    """Return controller (or "unified") -> mount point and the group that is mounted there."""
    mounts: dict[str, tuple[Path, str]] = {}
    for line in (proc / "mountinfo").read_text().splitlines():
        left, _, right = line.partition(" - ")
        root, point = left.split()[3:5]
        filesystem, _, options = right.split(" ", 2)
        if filesystem == "cgroup2":
            mounts["unified"] = (Path(point), root)
        elif filesystem == "cgroup":
            mounts |= dict.fromkeys(options.split(","), (Path(point), root))
    return mounts


def _own_groups(proc: Path) -> dict[str, str]:
    groups: dict[str, str] = {}
    for line in (proc / "cgroup").read_text().splitlines():
        _, controllers, path = line.split(":", 2)
        groups |= dict.fromkeys(controllers.split(",") if controllers else ["unified"], path)
    return groups


def _below(mount: tuple[Path, str], group: str) -> Path:
    point, root = mount
    inside = group if root == "/" else group.removeprefix(root)
    return point / inside.lstrip("/")


def _unified(mounts: dict[str, tuple[Path, str]], own: dict[str, str]) -> Path | None:
    """Return the version 2 group in which boxes get theirs, with its controllers enabled.

    1. our own group, if systemd delegated it to us (`Delegate=`); 2. the root of the hierarchy, if
    we may write there; 3. our own group without the mark: an older systemd shows it to root only.
    """
    if "unified" not in mounts:
        return None
    top, mine = mounts["unified"][0], _below(mounts["unified"], own.get("unified", "/"))
    if mine.name == LEAF:
        mine = mine.parent
    for folder in (mine, top) if _delegated(mine) else (top, mine):
        if os.access(folder / "cgroup.procs", os.W_OK) and _enable_controllers(folder):
            return folder
    return top if os.access(top, os.W_OK) else None


def _delegated(folder: Path) -> bool:
    """Return whether systemd delegated a group to its processes (its CGROUP_DELEGATION)."""
    with contextlib.suppress(OSError):
        return os.getxattr(folder, DELEGATED) == b"1"
    return False


def _controllers(folder: Path) -> set[str]:
    try:
        return set((folder / "cgroup.subtree_control").read_text().split())
    except OSError:
        return set()


def _enable_controllers(folder: Path) -> bool:
    """Enable the controllers for child groups; False if the host does not permit it."""
    with contextlib.suppress(OSError):
        if not REQUIRED <= set((folder / "cgroup.controllers").read_text().split()):
            return False
        if REQUIRED <= _controllers(folder):
            return True
        for _ in range(MOVE_ATTEMPTS):
            _move_to_leaf(folder)
            with contextlib.suppress(OSError):  # a process was started meanwhile
                (folder / "cgroup.subtree_control").write_text("+memory +pids")
                return True
    return False


def _move_to_leaf(folder: Path) -> None:
    """Move all processes of a group into a leaf: only the root may have processes and children."""
    if not (folder / "cgroup.type").exists():
        return
    leaf = folder / LEAF
    leaf.mkdir(exist_ok=True)
    for pid in (folder / "cgroup.procs").read_text().split():
        with contextlib.suppress(ProcessLookupError):  # it ended meanwhile
            (leaf / "cgroup.procs").write_text(pid)


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
            self._usage = os.open(self._paths.cpu / usage, os.O_RDONLY | os.O_CLOEXEC)
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

    def procs_files(self) -> list[str]:
        """Return the files by which the launcher joins the groups."""
        return [f"{folder}/cgroup.procs" for folder in self._paths.folders()]

    def cpu_s(self) -> float:
        """Return the CPU time that all processes used so far [s]."""
        text = os.pread(self._usage, 64, 0)
        if self._version == 2:
            return int(text.split(None, 2)[1]) / 1e6  # first line: usage_usec N
        return int(text) / 1e9

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
        """Kill every process in the group."""
        _kill(self._paths.unified or self._paths.pids)

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
