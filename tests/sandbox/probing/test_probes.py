"""A box on its host: known mistakes of other sandboxes, and different hosts."""

import json
import os
import shutil
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from seamark import sandbox
from seamark.sandbox.box import Box
from seamark.sandbox.isolation import proc_stats, uid_slots
from seamark.sandbox.isolation.bwrap_command import Descriptors, bwrap_command
from seamark.sandbox.isolation.cgroup_parents import CgroupPaths
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.readable_copies import COPIES
from seamark.sandbox.languages import LANGUAGES, language_of
from seamark.sandbox.languages.python.host import PACKAGES, package_folder, python_runtime
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Verdict
from seamark.sandbox.probing import probes
from seamark.sandbox.probing.probes import Finding, IsolationReport, probe

pytestmark = pytest.mark.host

CHECKOUT = Path(sandbox.__file__).resolve().parent.parent
LAYOUT = {
    "observation": [["t", 0], ["error", 3]],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
REPORT = """
    import json
    from seamark.sandbox import box
    from seamark.sandbox.isolation import cgroup_parents
    from seamark.sandbox.box import Box
    from seamark.sandbox.probing.probes import probe
    from seamark.sandbox.limits import Limits
    from seamark.sandbox.outcome import ProgramEnded
    LAYOUT = {"observation": [["t", 0], ["error", 3]]}
    found = probe()
    report = {"level": found.level.name, "why": found.sentence(), "package": box.__file__}
    strong = found.level.name == "STRONG"
    report["groups"] = str(cgroup_parents.parent_groups().memory) if strong else ""
    for name, source in json.loads(SOURCES).items():
        with Box(limits=Limits(cpu_s=1.0, memory_mib=192), isolation=found.level) as one:
            try:
                one.load(source.encode(), "a.py", {}, LAYOUT)
                one.step([0.0, 0.1, 0.2, 0.3])
                report[name] = one.finish().verdict
            except ProgramEnded as end:
                report[name] = end.outcome.verdict
    print(json.dumps(report))
"""
SOURCES = {
    "well": LANGUAGES["python"].self_test.text(),
    "heap": "x = [b'x' * (1 << 20) for _ in range(400)]",
    "spin": "while True: pass",
    "fork": "import os\nwhile True: os.fork()",
    "shadow": "open('/etc/shadow')",
}
SESSION = ("XDG_RUNTIME_DIR", "DBUS_SESSION_BUS_ADDRESS")  # where a user's systemd is found
as_root = pytest.mark.skipif(os.geteuid() != 0, reason="needs root")


def report(*before: str, path: str) -> dict[str, str]:
    """Run some programs in another process and return its report."""
    script = textwrap.dedent(REPORT).replace("SOURCES", repr(json.dumps(SOURCES)))
    command = [*before, sys.executable, "-c", script]
    session = {name: os.environ[name] for name in SESSION if name in os.environ}
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": path} | session
    done = subprocess.run(command, env=environment, cwd="/", capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    answer: dict[str, str] = json.loads(done.stdout)
    return answer


def verdicts_of(answer: dict[str, str]) -> dict[str, str]:
    return {name: answer[name] for name in SOURCES}


EXPECTED = {
    "well": Verdict.OK,
    "heap": Verdict.MEMORY_LIMIT,
    "spin": Verdict.TIME_LIMIT,
    "fork": Verdict.PROCESS_LIMIT,
    "shadow": Verdict.USER_ERROR,
}


def test_a_host_that_does_not_divide_the_cpu_time_is_told_how_to(tmp_path) -> None:
    without = CgroupPaths(tmp_path, tmp_path, tmp_path, None, tmp_path)

    divided = probes.cpu_shares(replace(without, cpu_shares=tmp_path))
    found = probes.cpu_shares(without)

    assert divided.ok
    assert not found.ok
    assert "Delegate" in found.remedy


@as_root
def test_bubblewrap_as_root_does_not_keep_uid_0(isolation) -> None:
    with Box(limits=Limits(), isolation=isolation) as box:
        box.wait_ready()
        uids = {proc_stats.uid_of(pid) for pid in box.processes()}

    assert uids <= set(range(uid_slots.FIRST_UID, uid_slots.FIRST_UID + uid_slots.SLOTS))


@as_root
def test_two_boxes_have_two_uids(isolation) -> None:
    with (
        Box(limits=Limits(), isolation=isolation) as one,
        Box(limits=Limits(), isolation=isolation) as two,
    ):
        one.wait_ready()
        two.wait_ready()
        uids = [proc_stats.uid_of(box.processes()[0]) for box in (one, two)]

    assert uids[0] != uids[1]


def test_proc_1_environ_is_empty_because_bubblewrap_was_started_with_nothing(
    isolation, monkeypatch
) -> None:
    monkeypatch.setenv("SEAMARK_SECRET_KEY", "do-not-tell")

    with Box(limits=Limits(), isolation=isolation) as box:
        box.wait_ready()
        init, *programs = box.processes()
        environments = [Path(f"/proc/{pid}/environ").read_bytes() for pid in (init, *programs)]

    assert environments[0] == b""
    assert not [text for text in environments if b"do-not-tell" in text]


CORE_LIMIT = """
    import resource, sys
    from pathlib import Path
    from seamark.sandbox.box import Box
    from seamark.sandbox.isolation.level import IsolationLevel
    from seamark.sandbox.limits import Limits
    resource.setrlimit(resource.RLIMIT_CORE, (int(sys.argv[2]), int(sys.argv[2])))
    with Box(limits=Limits(), isolation=IsolationLevel(int(sys.argv[1]))) as box:
        box.wait_ready()
        print(Path(f"/proc/{box.processes()[-1]}/limits").read_text())
"""


@pytest.mark.parametrize(("of_the_service", "of_the_box"), [(4096, 1), (1, 1), (0, 0)])
def test_a_crash_starts_no_handler_of_the_host_unless_the_service_had_no_limit_left(
    of_the_service, of_the_box, isolation
) -> None:
    script = textwrap.dedent(CORE_LIMIT)
    command = [sys.executable, "-c", script, str(int(isolation)), str(of_the_service)]

    limits = subprocess.run(command, capture_output=True, text=True, check=True).stdout

    line = next(line for line in limits.splitlines() if line.startswith("Max core file size"))
    assert line.split()[4:6] == [str(of_the_box)] * 2


def test_a_box_has_no_proc_no_etc_no_programs_and_sized_writable_folders() -> None:
    command = bwrap_command(
        python_runtime(),
        Limits(),
        Descriptors(3, 4, 5),
        limit_inside=False,
    )

    assert not {"--proc", "--dev", "--bind", "--bind-fd", "/etc", "/usr", "/usr/bin"} & set(command)
    sized = [command[i - 1] for i, word in enumerate(command) if word == "--tmpfs"]
    assert len(sized) == 3
    assert all(size.isdigit() for size in sized)
    assert command.index("--remount-ro") < command.index("--seccomp")


@as_root
@pytest.mark.slow
def test_a_plain_user_gets_medium_isolation_and_the_same_verdicts(tmp_path) -> None:
    if any(folder.stat().st_mode & 0o005 != 0o005 for folder in CHECKOUT.parents):
        pytest.skip("other users may not enter the checkout")
    become = ("setpriv", "--reuid", "54321", "--regid", "54321", "--clear-groups")

    answer = report(*become, path=str(CHECKOUT))

    assert answer["level"] == "MEDIUM", answer
    assert verdicts_of(answer) == EXPECTED


@pytest.mark.slow
def test_in_a_scope_delegated_by_systemd_every_user_gets_strong_isolation() -> None:
    manager = "--system" if os.geteuid() == 0 else "--user"
    scope = ("systemd-run", manager, "--scope", "--quiet", "--collect", "-p", "Delegate=yes")
    if (
        not shutil.which(scope[0])
        or subprocess.run([*scope, "true"], check=False, stderr=subprocess.DEVNULL).returncode
    ):
        pytest.skip("no systemd that delegates")

    answer = report(*scope, path=str(CHECKOUT))

    assert answer["level"] == "STRONG", answer
    assert answer["groups"].endswith(".scope")
    assert verdicts_of(answer) == EXPECTED


@as_root
@pytest.mark.slow
def test_checkout_and_packages_may_be_where_other_users_have_no_access(tmp_path, copies) -> None:
    home = tmp_path / "home"
    home.mkdir(mode=0o700)
    shutil.copytree(CHECKOUT / "sandbox", home / "checkout" / "sandbox")
    (home / "checkout" / "seamark").mkdir()
    (home / "checkout" / "seamark" / "__init__.py").touch()
    (home / "checkout" / "seamark" / "sandbox").symlink_to("../sandbox")
    for name, libraries in PACKAGES.items():
        folders = (package_folder(name), package_folder(name).with_name(libraries or name))
        for folder in dict.fromkeys(folders):
            copy = shutil.copytree if not _same_disk(folder, home) else _linked
            copy(folder, home / "packages" / folder.name)

    answer = report(path=f"{home / 'checkout'}:{home / 'packages'}")

    assert answer["package"].startswith(str(home))
    assert any(copies.glob("numpy-*"))
    assert answer["level"] == "STRONG", answer
    assert verdicts_of(answer) == EXPECTED


@pytest.fixture
def copies() -> Iterator[Path]:
    """Yield the folder of the copies; remove what the test adds."""
    before = set(COPIES.glob("*"))
    yield COPIES
    for path in set(COPIES.glob("*")) - before:
        shutil.rmtree(path) if path.is_dir() else path.unlink()


def _same_disk(one: Path, other: Path) -> bool:
    return one.stat().st_dev == other.stat().st_dev


def _linked(source: Path, target: Path) -> None:
    shutil.copytree(source, target, copy_function=os.link)


def test_a_host_without_bubblewrap_has_no_isolation_and_gets_a_remedy(monkeypatch) -> None:
    monkeypatch.setenv("PATH", "/nonexistent")

    found = probe()

    assert found.level is IsolationLevel.NONE
    assert any("apt-get install bubblewrap" in finding.remedy for finding in found.findings)


def test_the_status_line_names_what_is_missing() -> None:
    found = IsolationReport(
        IsolationLevel.MEDIUM, (Finding("a", ok=True), Finding("b", ok=False, why="no b"))
    )

    assert found.sentence() == "isolation medium (b: no b)"


@pytest.mark.parametrize(
    ("filename", "name"),
    [
        ("a.py", "python"),
        ("A.PY", "python"),
        ("a.pyc", None),
        ("py", "executable"),
        ("a.exe", None),
    ],
)
def test_the_suffix_determines_the_language(filename, name) -> None:
    assert language_of(filename) == name


def test_every_failed_finding_has_a_reason_and_a_remedy(monkeypatch) -> None:
    monkeypatch.setenv("PATH", "/nonexistent")

    bad = [finding for finding in probe().findings if not finding.ok]

    assert bad
    assert [finding for finding in bad if not finding.why or len(finding.remedy.split()) < 3] == []
