"""Finds the isolation level of this host by running small attacks in real boxes (one second)."""

import os
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from seamark.sandbox.box import Box
from seamark.sandbox.isolation import cgroup_parents, proc_stats, seccomp
from seamark.sandbox.isolation.bwrap_command import bubblewrap
from seamark.sandbox.isolation.cgroup_parents import CgroupPaths
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.process_tree import Layers
from seamark.sandbox.languages.python import PYTHON
from seamark.sandbox.languages.python.host import compile_packages
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded, SandboxBroken, Verdict

LIMITS = Limits(cpu_s=10.0, wall_s=20.0, memory_mib=192, processes=12)
LAYOUT = {
    "observation": [["t", 0], ["error", 3]],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
OBSERVATION = (0.0, 0.1, 0.2, 0.3)

MEMORY = """\
class Controller:
    def __init__(self, config):
        self.heap = [b"x" * (1 << 20) for _ in range(400)]
    def step(self, observation): ...
"""
PROCESSES = """\
import os, time
class Controller:
    def __init__(self, config):
        for _ in range(40):
            if os.fork() == 0:
                time.sleep(30)
    def step(self, observation): ...
"""
SURVIVOR = """\
import os, time
class Controller:
    def __init__(self, config):
        if os.fork() == 0:
            os.setpgid(0, 0)
            if os.fork():
                os._exit(0)
            time.sleep(600)
    def step(self, observation): ...
"""

REMEDY = {
    "bubblewrap": "apt-get install bubblewrap",
    "system calls": "run the worker on an x86_64 machine",
    "box": "allow user namespaces: sysctl -w kernel.unprivileged_userns_clone=1 (Debian), "
    "sysctl -w kernel.apparmor_restrict_unprivileged_userns=0 (Ubuntu); in a container, a "
    "seccomp profile that permits them",
    "control groups": "start it with `./run`, which gets a scope of its own from systemd if "
    "possible (log in as the user: `su` and `sudo -u` open no session), as a systemd service with "
    "Delegate=yes, or as root",
    "CPU shares": "have the cpu controller delegated too: Delegate=yes in the unit, or for a login "
    "session Delegate=cpu memory pids in user@.service",
    "own uid": "run the worker as root, so that each box gets a uid of its own, or give it a "
    "delegated control group",
    "compiled packages": "python -m compileall -q on the folders of numpy, scipy, cv2 and "
    "onnxruntime",
}

UNEXPECTED = (  # if an attack succeeds that no setting of a host should permit
    "do not accept uploads from others here, and report this with the output of `seamark doctor`: "
    "bubblewrap or the kernel does not isolate as it should (update both first)"
)


@dataclass(frozen=True, slots=True)
class Finding:
    """One probe: what was tried, whether the sandbox held, why not, and how to fix it."""

    name: str
    ok: bool
    why: str = ""
    remedy: str = ""


@dataclass(frozen=True, slots=True)
class IsolationReport:
    """The isolation level that this host reaches, with the findings that decided it."""

    level: IsolationLevel
    findings: tuple[Finding, ...] = ()

    def sentence(self) -> str:
        """Return one line for a status page: the level and what is missing for the next one."""
        missing = "; ".join(f"{f.name}: {f.why}" for f in self.findings if not f.ok)
        return f"isolation {self.level.name.lower()}" + (f" ({missing})" if missing else "")


def probe() -> IsolationReport:
    """Run the attacks in real boxes; return the isolation level that held, and all findings."""
    findings = [*_requirements()]
    if not all(finding.ok for finding in findings):
        return IsolationReport(IsolationLevel.NONE, tuple(findings))
    groups = _try("control groups", cgroup_parents.parent_groups)
    compiled = Finding("compiled packages", compile_packages())
    findings += [groups, _explained(compiled, "each box starts 100 ms later")]
    findings += [cpu_shares(cgroup_parents.parent_groups())] if groups.ok else []
    for isolation in (
        (IsolationLevel.STRONG, IsolationLevel.MEDIUM) if groups.ok else (IsolationLevel.MEDIUM,)
    ):
        attacks = [*_attacks(isolation)]
        if all(finding.ok for finding in attacks):
            return IsolationReport(isolation, (*findings, *attacks))
        findings += [finding for finding in attacks if not finding.ok]
    return IsolationReport(IsolationLevel.NONE, tuple(findings))


def cpu_shares(parents: CgroupPaths) -> Finding:
    """Return whether boxes share the CPU time equally, however many processes one has."""
    divided = Finding("CPU shares", parents.cpu_shares is not None)
    return _explained(divided, "a program with many processes slows down those of others")


def _requirements() -> Iterator[Finding]:
    """Yield the requirements without which no box can start."""
    yield _try("bubblewrap", bubblewrap)
    machine = Finding("system calls", seccomp.supported())
    yield _explained(machine, f"the filter supports {seccomp.MACHINE} only")


def _attacks(isolation: IsolationLevel) -> Iterator[Finding]:
    """Yield one finding for each attack; ends early if a box does not start."""
    try:
        yield from _in_boxes(isolation)
    except SandboxBroken as error:  # on a very slow host some boxes start too late
        yield _explained(Finding("box", ok=False), str(error))


def _in_boxes(isolation: IsolationLevel) -> Iterator[Finding]:
    box = _try("box", lambda: _outcome(PYTHON.self_test.text(), isolation))
    yield box
    if not box.ok:
        return
    yield from _from_inside(isolation)
    yield _ends("memory", MEMORY, isolation, Verdict.MEMORY_LIMIT)
    yield _ends("processes", PROCESSES, isolation, Verdict.PROCESS_LIMIT)
    yield _try("survivors", lambda: _outcome(SURVIVOR, isolation))
    yield _uid(isolation)


def _try(name: str, action: Callable[[], object]) -> Finding:
    try:
        action()
    except SandboxBroken as error:
        return _explained(Finding(name, ok=False), str(error))
    return Finding(name, ok=True)


def _explained(finding: Finding, why: str) -> Finding:
    """Return the finding with its reason and remedy if it failed."""
    if finding.ok:
        return finding
    return replace(finding, why=why, remedy=REMEDY.get(finding.name, UNEXPECTED))


def _outcome(
    source: str, isolation: IsolationLevel, config: dict[str, object] | None = None
) -> Outcome:
    """Run a program for one step and return how it ended."""
    with Box(limits=LIMITS, isolation=isolation) as box:
        try:
            box.load(source.encode(), "probe.py", config or {}, LAYOUT)
            box.step(OBSERVATION)
            return box.finish()
        except ProgramEnded as end:
            return end.outcome


def _ends(name: str, source: str, isolation: IsolationLevel, expected: Verdict) -> Finding:
    outcome = _outcome(source, isolation)
    why = f"expected {expected}, got {outcome.verdict}: {outcome.sentence}"
    return _explained(Finding(name, outcome.verdict is expected), why)


def _from_inside(isolation: IsolationLevel) -> Iterator[Finding]:
    """Yield what the attacks in probe_program.py achieved."""
    source = Path(__file__).with_name("probe_program.py").read_text(encoding="utf-8")
    with tempfile.NamedTemporaryFile() as canary:
        os.fchmod(canary.fileno(), 0o644)
        outcome = _outcome(source, isolation, {"canary": canary.name})
    if outcome.verdict is not Verdict.OK:
        yield _explained(Finding("attacks", ok=False), outcome.sentence)
    for line in outcome.output.decode().splitlines():
        name, _, got = line.partition("\t")
        yield _explained(Finding(name.replace("_", " "), not got), f"a program gets {got}")


def _uid(isolation: IsolationLevel) -> Finding:
    """Return whether a program runs under a uid that owns nothing else on this host.

    A plain user's boxes have the worker's own uid: enough only with a control group around them.
    """
    with Box(limits=LIMITS, isolation=isolation) as box:
        box.wait_ready()
        uids = {proc_stats.uid_of(pid) for pid in box.processes()}
    ok = 0 not in uids and (os.geteuid() not in uids or isolation is IsolationLevel.STRONG)
    own = Finding("own uid", ok or not Layers.of(isolation).own_uid)
    return _explained(own, f"programs run as uid {sorted(uids)}")
