"""Control groups of version 2, as in an ordinary Debian 12, simulated by files.

The host of these tests may have version 1: what the kernel does is stood in for, by the files that
it makes with a group (cgroup-v2.rst) and takes away with it. The same code runs on a real kernel of
version 1 or 2 in every other test of the sandbox.
"""

import os
import shutil
from pathlib import Path

import pytest

from seamark.sandbox.isolation import cgroups
from seamark.sandbox.isolation.cgroups import CgroupPaths, ControlGroup, Kernel
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import SandboxBroken

FILES = {
    "cgroup.procs": "",
    "cgroup.kill": "",
    "cgroup.events": "populated 0\nfrozen 0\n",
    "cpu.stat": "usage_usec 1234567\nuser_usec 1000000\nsystem_usec 234567\n",
    "memory.max": "max\n",
    "memory.swap.max": "max\n",
    "memory.oom.group": "0\n",
    "memory.peak": "52428800\n",
    "memory.events": "low 0\nhigh 0\nmax 31\noom 2\noom_kill 1\noom_group_kill 0\n",
    "pids.max": "max\n",
    "pids.events": "max 3\n",
}
TOP = {
    "cgroup.procs": "1\n",
    "cgroup.controllers": "cpuset cpu io memory hugetlb pids\n",
    "cgroup.subtree_control": "cpu memory pids\n",
}
LIMITS = Limits(memory_mib=256, processes=20)


class Version2(Kernel):
    """Creates and removes a group with its files."""

    @staticmethod
    def create(folder: Path) -> None:
        folder.mkdir()
        for name, text in FILES.items():
            (folder / name).write_text(text)

    @staticmethod
    def remove(folder: Path) -> None:
        if (folder / "cgroup.procs").read_text():
            raise OSError("busy")
        shutil.rmtree(folder)


class Busy(Version2):
    """A group in which a process survives."""

    @staticmethod
    def remove(folder: Path) -> None:
        raise OSError("busy")


def laid(folder: Path, files: dict[str, str]) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


@pytest.fixture
def top(tmp_path: Path) -> Path:
    return laid(tmp_path / "cgroup", TOP)


@pytest.fixture
def group(top: Path) -> ControlGroup:
    return ControlGroup(LIMITS, parents=CgroupPaths(top, top, top, top), kernel=Version2)


def proc(tmp_path: Path, top: Path, own: str, *, root: str = "/") -> Path:
    """Return the folder of a process whose own group is `own`."""
    mount = f"35 24 0:30 {root} {top} rw,nosuid shared:9 - cgroup2 cgroup2 rw,nsdelegate\n"
    return laid(tmp_path / "proc", {"mountinfo": mount, "cgroup": f"0::{own}\n"})


def test_a_host_with_version_2_only_has_all_groups_in_one_folder(tmp_path, top) -> None:
    found = cgroups.parent_groups(proc(tmp_path, top, "/"))

    assert found == CgroupPaths(top, top, top, top)
    assert found.folders() == [top]


def test_available_controllers_are_enabled(top) -> None:
    (top / "cgroup.subtree_control").write_text("")

    assert cgroups._unified({"unified": (top, "/")}, {"unified": "/"}) == top

    assert (top / "cgroup.subtree_control").read_text() == "+memory +pids"


def test_in_a_delegated_service_the_processes_are_moved_to_a_leaf_first(top) -> None:
    own = laid(top / "system.slice/seamark.service", TOP | {"cgroup.subtree_control": ""})
    laid(own, {"cgroup.type": "domain\n", "cgroup.procs": "41\n"})
    (top / "cgroup.controllers").write_text("")  # the top is not ours to change

    cgroups._unified({"unified": (top, "/")}, {"unified": "/system.slice/seamark.service"})

    assert (own / "seamark-service/cgroup.procs").read_text() == "41"
    assert (own / "cgroup.subtree_control").read_text() == "+memory +pids"


def test_a_group_delegated_by_systemd_comes_before_the_root(top) -> None:
    own = laid(top / "system.slice/seamark.service", TOP | {"cgroup.type": "domain\n"})
    where = {"unified": (top, "/")}, {"unified": "/system.slice/seamark.service/seamark-service"}
    unmarked = cgroups._unified(*where)
    try:
        os.setxattr(own, cgroups.DELEGATED, b"1")
    except OSError:
        pytest.skip("this file system keeps no marks")

    assert (unmarked, cgroups._unified(*where)) == (top, own)


def test_a_process_that_ended_meanwhile_does_not_stop_the_move(top, monkeypatch) -> None:
    own = laid(top / "scope", {"cgroup.type": "domain\n", "cgroup.procs": "41\n42\n"})
    write = Path.write_text

    def refuses_41(path: Path, text: str) -> int:
        if text == "41":
            raise ProcessLookupError
        return write(path, text)

    monkeypatch.setattr(Path, "write_text", refuses_41)

    cgroups._move_to_leaf(own)

    assert (own / cgroups.LEAF / "cgroup.procs").read_text() == "42"


def test_a_host_without_the_controllers_is_refused_with_the_reason(tmp_path, top) -> None:
    (top / "cgroup.controllers").write_text("hugetlb\n")
    (top / "cgroup.subtree_control").write_text("hugetlb\n")

    with pytest.raises(SandboxBroken, match="memory and pids"):
        cgroups.parent_groups(proc(tmp_path, top, "/"))


def test_version_1_with_a_version_2_that_can_only_kill_uses_both(tmp_path, top) -> None:
    for name in ("memory", "pids", "cpu,cpuacct"):
        laid(tmp_path / name, {})
    lines = [
        f"{number} 24 0:3 / {tmp_path / name} rw - cgroup cgroup rw,{name}"
        for number, name in enumerate(("memory", "pids", "cpu,cpuacct"))
    ]
    (top / "cgroup.controllers").write_text("hugetlb\n")
    (top / "cgroup.subtree_control").write_text("")
    mount = f"35 24 0:30 / {top} rw - cgroup2 cgroup2 rw"
    here = laid(
        tmp_path / "proc",
        {
            "mountinfo": "\n".join([*lines, mount]),
            "cgroup": "3:memory:/\n2:pids:/\n1:cpu,cpuacct:/\n0::/\n",
        },
    )

    found = cgroups.parent_groups(here)

    assert found == CgroupPaths(
        tmp_path / "memory", tmp_path / "pids", tmp_path / "cpu,cpuacct", top
    )


def test_the_limits_are_written_to_the_files_of_version_2(group, top) -> None:
    folder = top / group.name

    assert (folder / "memory.max").read_text() == str(256 << 20)
    assert (folder / "memory.swap.max").read_text() == "0"
    assert (folder / "memory.oom.group").read_text() == "1"
    assert (folder / "pids.max").read_text() == str(20 + cgroups.OVERHEAD_PROCESSES)
    assert group.procs_files() == [f"{folder}/cgroup.procs"]
    group.remove()


def test_the_counters_are_read_from_the_files_of_version_2(group) -> None:
    assert group.cpu_s() == 1.234567
    assert group.memory_mib() == 50.0
    assert group.out_of_memory()
    assert group.out_of_processes()
    group.remove()


def test_a_kill_for_the_memory_of_a_parent_group_is_not_the_boxs(group, top) -> None:
    blamed = group.out_of_memory(), group.host_out_of_memory()
    # As Linux 7.2 counts for a box of 128 MiB in a group of 96.
    events = "low 0\nhigh 0\nmax 0\noom 0\noom_kill 2\noom_group_kill 1\n"
    (top / group.name / "memory.events").write_text(events)

    assert blamed == (True, False)
    assert (group.out_of_memory(), group.host_out_of_memory()) == (False, True)
    group.remove()


def test_without_files_for_peak_and_events_both_are_0(group, top) -> None:
    (top / group.name / "memory.peak").unlink()
    (top / group.name / "memory.events").write_text("oom 0\noom_kill 0\n")
    (top / group.name / "pids.events").unlink()

    assert group.memory_mib() == 0.0
    assert not group.out_of_memory()
    assert not group.host_out_of_memory()
    assert not group.out_of_processes()
    group.remove()


def test_all_processes_are_killed_by_one_write_and_the_group_is_removed(group, top) -> None:
    group.kill()

    assert (top / group.name / "cgroup.kill").read_text() == "1"
    before = len(os.listdir("/proc/self/fd"))
    group.remove()
    assert not (top / group.name).exists()
    assert len(os.listdir("/proc/self/fd")) == before - 1


def test_a_group_that_cannot_be_removed_is_reported_to_have_survivors(top, monkeypatch) -> None:
    monkeypatch.setattr(cgroups, "REMOVE_WITHIN_S", 0.01)
    group = ControlGroup(LIMITS, parents=CgroupPaths(top, top, top, top), kernel=Busy)

    with pytest.raises(SandboxBroken, match="processes survive"):
        group.remove()
