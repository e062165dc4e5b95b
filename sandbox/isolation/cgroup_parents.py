"""Where on this host the control groups of boxes are created.

Works with cgroup version 1, version 2 and both mixed: it looks for controllers, not for a version.
Version 2 offers `cgroup.kill` even where it has no controllers.
"""

import contextlib
import os
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from seamark.sandbox.outcome import SandboxBroken

LEAF = "seamark-service"  # the group of the service's own processes, beside its boxes
DELEGATED = "user.delegate"  # systemd sets it since version 251
REQUIRED = {"memory", "pids"}
WANTED = REQUIRED | {"cpu"}
MOVE_ATTEMPTS = 20  # processes may be started while others are moved
# cpu.weight: as much as eight boxes (cgroups.py), since pages and simulators serve everybody
LEAF_WEIGHT = 400


@dataclass(frozen=True, slots=True)
class CgroupPaths:
    """Where groups are created. A version 2 hierarchy may hold all controllers or none."""

    memory: Path
    pids: Path
    cpu_usage: Path
    cpu_shares: Path | None  # None if the host does not let us divide the CPU time
    unified: Path | None  # for cgroup.kill

    def folders(self) -> list[Path]:
        """Return each folder once."""
        every = {self.memory, self.pids, self.cpu_usage, self.cpu_shares, self.unified}
        return sorted(folder for folder in every if folder is not None)

    def child(self, name: str) -> "CgroupPaths":
        """Return the paths of a child group."""
        return CgroupPaths(
            self.memory / name,
            self.pids / name,
            self.cpu_usage / name,
            self.cpu_shares / name if self.cpu_shares else None,
            self.unified / name if self.unified else None,
        )


PROC = Path("/proc/self")


@cache
def parent_groups(proc: Path = PROC) -> CgroupPaths:
    """Return the groups in which boxes get theirs; SandboxBroken with the reason if none."""
    mounts = _mounts(proc)
    own = _own_groups(proc)
    v1 = {
        name: _below(mounts[name], own.get(name, "/"))
        for name in ("memory", "pids", "cpuacct", "cpu")
        if name in mounts
    }
    unified = _unified(mounts, own)
    if unified is not None and REQUIRED <= (enabled := _controllers(unified)):
        shares = unified if "cpu" in enabled else None
        paths = CgroupPaths(unified, unified, unified, shares, unified)
    elif {"memory", "pids", "cpuacct"} <= v1.keys():
        shares = v1["cpu"] if "cpu" in v1 and os.access(v1["cpu"], os.W_OK) else None
        paths = CgroupPaths(v1["memory"], v1["pids"], v1["cpuacct"], shares, unified)
    else:
        raise SandboxBroken("no control groups with the memory and pids controllers")
    for folder in {paths.memory, paths.pids, paths.cpu_usage}:
        if not os.access(folder, os.W_OK):
            raise SandboxBroken(f"no permission to create control groups in {folder}")
    return paths


def _mounts(proc: Path) -> dict[str, tuple[Path, str]]:
    """Return controller (or "unified") -> mount point and the group that is mounted there."""
    mounts: dict[str, tuple[Path, str]] = {}
    for line in (proc / "mountinfo").read_text().splitlines():
        mount, _, superblock = line.partition(" - ")
        root, point = mount.split()[3:5]
        filesystem, _, options = superblock.split(" ", 2)
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
        available = set((folder / "cgroup.controllers").read_text().split())
        if not REQUIRED <= available:
            return False
        if available & WANTED <= _controllers(folder):
            return True
        for _ in range(MOVE_ATTEMPTS):
            _move_to_leaf(folder)
            if _enabled(folder, available & WANTED) or _enabled(folder, REQUIRED):
                return True
    return False


def _enabled(folder: Path, controllers: set[str]) -> bool:
    """Enable these controllers; False if a process was started meanwhile, or one is in use."""
    with contextlib.suppress(OSError):
        names = " ".join(f"+{name}" for name in sorted(controllers))
        (folder / "cgroup.subtree_control").write_text(names)
        with contextlib.suppress(OSError):  # neither at the top of the hierarchy nor without "cpu"
            (folder / LEAF / "cpu.weight").write_text(str(LEAF_WEIGHT))
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
