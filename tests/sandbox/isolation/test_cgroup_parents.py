"""Where the control groups of boxes are created, on hosts that are simulated by files."""

import os
from pathlib import Path

import pytest

from seamark.sandbox.isolation import cgroup_parents, cgroups
from seamark.sandbox.isolation.cgroup_parents import CgroupPaths
from seamark.sandbox.outcome import SandboxBroken

TOP = {
    "cgroup.procs": "1\n",
    "cgroup.controllers": "cpuset cpu io memory hugetlb pids\n",
    "cgroup.subtree_control": "cpu memory pids\n",
}


def laid(folder: Path, files: dict[str, str]) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


@pytest.fixture
def top(tmp_path: Path) -> Path:
    return laid(tmp_path / "cgroup", TOP)


def proc(tmp_path: Path, top: Path, own: str, *, root: str = "/") -> Path:
    """Return the folder of a process whose own group is `own`."""
    mount = f"35 24 0:30 {root} {top} rw,nosuid shared:9 - cgroup2 cgroup2 rw,nsdelegate\n"
    return laid(tmp_path / "proc", {"mountinfo": mount, "cgroup": f"0::{own}\n"})


def test_a_host_with_version_2_only_has_all_groups_in_one_folder(tmp_path, top) -> None:
    found = cgroup_parents.parent_groups(proc(tmp_path, top, "/"))

    assert found == CgroupPaths(top, top, top, top, top)
    assert found.folders() == [top]


def test_available_controllers_are_enabled(top) -> None:
    (top / "cgroup.subtree_control").write_text("")

    assert cgroup_parents._unified({"unified": (top, "/")}, {"unified": "/"}) == top

    assert (top / "cgroup.subtree_control").read_text() == "+cpu +memory +pids"


def test_without_the_cpu_controller_the_others_are_enabled(top) -> None:
    (top / "cgroup.controllers").write_text("memory pids\n")
    (top / "cgroup.subtree_control").write_text("")

    cgroup_parents._unified({"unified": (top, "/")}, {"unified": "/"})

    assert (top / "cgroup.subtree_control").read_text() == "+memory +pids"


def test_boxes_have_no_shares_where_the_cpu_controller_is_missing(tmp_path, top) -> None:
    (top / "cgroup.controllers").write_text("memory pids\n")
    (top / "cgroup.subtree_control").write_text("memory pids\n")

    found = cgroup_parents.parent_groups(proc(tmp_path, top, "/"))

    assert found == CgroupPaths(top, top, top, None, top)


def test_the_service_gets_more_of_the_cpu_time_than_its_boxes(top) -> None:
    own = laid(top / "system.slice/seamark.service", TOP | {"cgroup.subtree_control": ""})
    laid(own, {"cgroup.type": "domain\n", "cgroup.procs": "41\n"})
    (top / "cgroup.controllers").write_text("")

    cgroup_parents._unified({"unified": (top, "/")}, {"unified": "/system.slice/seamark.service"})

    weight = (own / "seamark-service/cpu.weight").read_text()
    assert int(weight) > cgroups.CPU_WEIGHT


def test_in_a_delegated_service_the_processes_are_moved_to_a_leaf_first(top) -> None:
    own = laid(top / "system.slice/seamark.service", TOP | {"cgroup.subtree_control": ""})
    laid(own, {"cgroup.type": "domain\n", "cgroup.procs": "41\n"})
    (top / "cgroup.controllers").write_text("")  # the top is not ours to change

    cgroup_parents._unified({"unified": (top, "/")}, {"unified": "/system.slice/seamark.service"})

    assert (own / "seamark-service/cgroup.procs").read_text() == "41"
    assert (own / "cgroup.subtree_control").read_text() == "+cpu +memory +pids"


def test_a_group_delegated_by_systemd_comes_before_the_root(top) -> None:
    own = laid(top / "system.slice/seamark.service", TOP | {"cgroup.type": "domain\n"})
    where = {"unified": (top, "/")}, {"unified": "/system.slice/seamark.service/seamark-service"}
    unmarked = cgroup_parents._unified(*where)
    try:
        os.setxattr(own, cgroup_parents.DELEGATED, b"1")
    except OSError:
        pytest.skip("this file system keeps no marks")

    assert (unmarked, cgroup_parents._unified(*where)) == (top, own)


def test_a_process_that_ended_meanwhile_does_not_stop_the_move(top, monkeypatch) -> None:
    own = laid(top / "scope", {"cgroup.type": "domain\n", "cgroup.procs": "41\n42\n"})
    write = Path.write_text

    def refuses_41(path: Path, text: str) -> int:
        if text == "41":
            raise ProcessLookupError
        return write(path, text)

    monkeypatch.setattr(Path, "write_text", refuses_41)

    cgroup_parents._move_to_leaf(own)

    assert (own / cgroup_parents.LEAF / "cgroup.procs").read_text() == "42"


def test_a_host_without_the_controllers_is_refused_with_the_reason(tmp_path, top) -> None:
    (top / "cgroup.controllers").write_text("hugetlb\n")
    (top / "cgroup.subtree_control").write_text("hugetlb\n")

    with pytest.raises(SandboxBroken, match="memory and pids"):
        cgroup_parents.parent_groups(proc(tmp_path, top, "/"))


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

    found = cgroup_parents.parent_groups(here)

    assert found == CgroupPaths(
        tmp_path / "memory",
        tmp_path / "pids",
        tmp_path / "cpu,cpuacct",
        tmp_path / "cpu,cpuacct",
        top,
    )
