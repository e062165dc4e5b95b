"""Control groups of version 2, as in an ordinary Debian 12, simulated by files.

The host of these tests may have version 1: what the kernel does is stood in for, by the files that
it makes with a group (cgroup-v2.rst) and takes away with it. The same code runs on a real kernel of
version 1 or 2 in every other test of the sandbox.
"""

import shutil
import signal
import subprocess
from pathlib import Path

import pytest

from seamark.sandbox.isolation import cgroups
from seamark.sandbox.isolation.cgroup_parents import CgroupPaths
from seamark.sandbox.isolation.cgroups import ControlGroup, Kernel
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import SandboxBroken
from tests.sandbox.conftest import descriptors

FILES = {
    "cgroup.procs": "",
    "cgroup.kill": "",
    "cgroup.events": "populated 0\nfrozen 0\n",
    "cpu.weight": "100\n",
    "cpu.stat": "usage_usec 1234567\nuser_usec 1000000\nsystem_usec 234567\n",
    "memory.max": "max\n",
    "memory.swap.max": "max\n",
    "memory.oom.group": "0\n",
    "memory.peak": "52428800\n",
    "memory.events": "low 0\nhigh 0\nmax 31\noom 2\noom_kill 1\noom_group_kill 0\n",
    "pids.max": "max\n",
    "pids.events": "max 3\n",
}
LIMITS = Limits(memory_mib=256, processes=20)


def descriptors_within(folder: Path) -> list[str]:
    """Return what this process has open there, deleted or not, whatever other tests left open."""
    return [target for _, target in descriptors() if target.startswith(str(folder))]


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


@pytest.fixture
def top(tmp_path: Path) -> Path:
    return tmp_path


@pytest.fixture
def group(top: Path) -> ControlGroup:
    return ControlGroup(LIMITS, parents=CgroupPaths(top, top, top, top, top), kernel=Version2)


def test_the_limits_are_written_to_the_files_of_version_2(group, top) -> None:
    folder = top / group.name

    assert (folder / "memory.max").read_text() == str(256 << 20)
    assert (folder / "memory.swap.max").read_text() == "0"
    assert (folder / "memory.oom.group").read_text() == "1"
    assert (folder / "pids.max").read_text() == str(20 + cgroups.OVERHEAD_PROCESSES)
    assert (folder / "cpu.weight").read_text() == str(cgroups.CPU_WEIGHT)
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
    assert len(descriptors_within(top)) == 1
    group.remove()
    assert not (top / group.name).exists()
    assert descriptors_within(top) == []


def test_a_group_that_cannot_be_removed_is_reported_to_have_survivors(top, monkeypatch) -> None:
    monkeypatch.setattr(cgroups, "REMOVE_WITHIN_S", 0.01)
    group = ControlGroup(LIMITS, parents=CgroupPaths(top, top, top, top, top), kernel=Busy)

    with pytest.raises(SandboxBroken, match="processes survive"):
        group.remove()


def test_a_box_has_no_share_of_its_own_where_the_host_does_not_divide_the_cpu_time(top) -> None:
    group = ControlGroup(LIMITS, parents=CgroupPaths(top, top, top, None, top), kernel=Version2)

    assert (top / group.name / "cpu.weight").read_text() == FILES["cpu.weight"]
    group.remove()


def test_with_version_1_a_box_has_its_share_in_the_hierarchy_of_the_cpu_controller(
    tmp_path,
) -> None:
    paths = [tmp_path / name for name in ("memory", "pids", "cpuacct", "cpu", "unified")]
    for path in paths:
        path.mkdir()

    class Version1(Kernel):
        @staticmethod
        def create(folder: Path) -> None:
            folder.mkdir()
            (folder / "cpuacct.usage").write_text("0\n")

        @staticmethod
        def remove(folder: Path) -> None:
            shutil.rmtree(folder)

    group = ControlGroup(LIMITS, parents=CgroupPaths(*paths), kernel=Version1)

    shares = (tmp_path / "cpu" / group.name / "cpu.shares").read_text()
    group.remove()
    assert shares == str(cgroups.CPU_SHARES)
    assert [*(tmp_path / "cpu").iterdir()] == []


def test_a_process_that_had_entered_only_some_hierarchies_of_version_1_is_ended_too(
    tmp_path,
) -> None:
    paths = [tmp_path / name for name in ("memory", "pids", "cpuacct", "cpu", "unified")]
    for path in paths:
        path.mkdir()

    with subprocess.Popen(["/bin/sleep", "60"]) as process:

        class Version1(Kernel):
            @staticmethod
            def create(folder: Path) -> None:
                folder.mkdir()
                inside = str(process.pid) if folder.parent.name == "cpu" else ""
                (folder / "cgroup.procs").write_text(inside)
                (folder / "cpuacct.usage").write_text("0\n")

            @staticmethod
            def remove(folder: Path) -> None:
                if (folder / "cgroup.procs").read_text() and process.poll() is None:
                    raise OSError("busy")
                shutil.rmtree(folder)

        try:
            ControlGroup(LIMITS, parents=CgroupPaths(*paths), kernel=Version1).remove()
            assert process.wait(10) == -signal.SIGKILL
        finally:
            process.kill()
