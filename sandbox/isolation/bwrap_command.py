"""How a box is started: the command line of bubblewrap and the orders of the launcher.

Namespaces: all. Root: a new tmpfs with what the language needs, read-only, without /proc. Writable
are /tmp and /dev/shm, both sized. bubblewrap's own `--dev` would be a writable tmpfs of half the
memory, therefore five device nodes are bound into a small one.
"""

import math
import os
import shutil
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Self

from seamark.sandbox.languages.language import Runtime
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import SandboxBroken

DEVICES = ("null", "zero", "full", "random", "urandom")
DEV_BYTES = 65536  # [B] room for the mount points of /dev
LOCKED_BYTES = 65536  # [B] RLIMIT_MEMLOCK
STACK_BYTES = 8 << 20  # [B] RLIMIT_STACK
INNER_PROCESSES = 1  # bubblewrap's own, in the same namespace
FIRST_DESCRIPTOR = 3  # in the box: the protocol's, after standard input, output and error
IMAGES_DESCRIPTOR = 4
CPU_GRACE_S = 10  # [s] RLIMIT_CPU, which counts the start too, is a lost worker's backstop

NAMESPACES = ("user", "ipc", "pid", "net", "uts", "cgroup")


@dataclass(frozen=True, slots=True)
class Descriptors:
    """Numbers of what bubblewrap inherits; it closes its own two before the program."""

    protocol: int  # of these the program keeps this one
    information: int  # it writes the pid of its inner init and the end of the program here
    filter: int | None  # the system call filter
    images: int | None = None  # and this one, if it is shown images; else its runner closes it

    def inherited(self) -> tuple[int, ...]:
        """Return all of them; the program's own come first."""
        every = (self.protocol, self.images, self.information, self.filter)
        return tuple(number for number in every if number is not None)

    def inside(self) -> Self:
        """Return the numbers that the launcher gives them.

        They do not tell how many files the worker has open, and are the same in every run.
        """
        moved = dict(zip(self.inherited(), count(FIRST_DESCRIPTOR), strict=False))
        return type(self)(
            protocol=moved[self.protocol],
            information=moved[self.information],
            filter=None if self.filter is None else moved[self.filter],
            images=None if self.images is None else moved[self.images],
        )


def bubblewrap() -> str:
    """Return the path of bwrap; SandboxBroken with the remedy if there is none."""
    found = shutil.which("bwrap", path=os.environ.get("PATH", "/usr/bin:/bin"))
    if found is None:
        raise SandboxBroken("bubblewrap is not installed (apt-get install bubblewrap)")
    return found


def bwrap_command(
    runtime: Runtime,
    limits: Limits,
    use: Descriptors,
    *,
    limit_inside: bool,
    namespaces: Sequence[str] = NAMESPACES,
) -> list[str]:
    """Return bubblewrap's command line.

    `use` has the numbers inside. `namespaces` are fewer only in tests. `limit_inside` lets the
    runner limit processes and memory, where no control group does.
    """
    command = [bubblewrap(), *(f"--unshare-{name}" for name in namespaces)]
    command += ["--hostname", "sandbox"] if "uts" in namespaces else []
    command += ["--disable-userns", "--uid", "1000", "--gid", "1000"]
    command += ["--die-with-parent", "--new-session", "--cap-drop", "ALL", "--clearenv"]
    command += ["--json-status-fd", str(use.information)]
    for name, value in runtime.environment.items():
        command += ["--setenv", name, value]
    command += _libraries()
    for bind in runtime.binds:
        command += ["--ro-bind", str(bind.source), bind.target]
    command += _writable(limits)
    command += ["--remount-ro", "/", "--chdir", "/tmp"]  # noqa: S108  (inside the box)
    if use.filter is not None:
        command += ["--seccomp", str(use.filter)]
    processes = limits.processes + INNER_PROCESSES if limit_inside else 0
    memory_mib = limits.memory_mib if limit_inside else 0
    numbers = (use.protocol, processes, memory_mib)
    return [*command, "--", *runtime.command, *map(str, numbers)]


def _libraries() -> Iterator[str]:
    """Yield the options for the system's libraries: no programs, no /etc, no /home."""
    multiarch = Path("/usr/lib/x86_64-linux-gnu")
    for folder in (multiarch, Path("/usr/lib64")):
        if folder.is_dir():
            yield from ("--ro-bind", str(folder), str(folder))
    for link in (Path("/lib"), Path("/lib64")):
        if link.is_symlink():
            yield from ("--symlink", os.readlink(link), str(link))
        elif link.is_dir():
            yield from ("--ro-bind", str(link), str(link))


def _writable(limits: Limits) -> Iterator[str]:
    yield from ("--perms", "0755", "--size", str(DEV_BYTES), "--tmpfs", "/dev")
    for name in DEVICES:
        yield from ("--dev-bind", f"/dev/{name}", f"/dev/{name}")
    for folder, size in (("/dev/shm", limits.shared_mib), ("/tmp", limits.tmp_mib)):  # noqa: S108
        yield from ("--perms", "1777", "--size", str(size << 20), "--tmpfs", folder)
    yield from ("--remount-ro", "/dev")


def launcher_command(
    command: list[str],
    limits: Limits,
    inherited: Sequence[int],
    *,
    groups: list[str],
    uid: int | None,
    core: int | None,
) -> list[str]:
    """Return the command line of the launcher that becomes bubblewrap."""
    orders = [f"descriptors={','.join(map(str, (FIRST_DESCRIPTOR, *inherited)))}"]
    orders += [f"group={entry}" for entry in groups]
    orders += [] if core is None else [f"core={core}"]
    resources = {
        "RLIMIT_CORE": 0,
        "RLIMIT_CPU": math.ceil(limits.cpu_s) + CPU_GRACE_S,
        "RLIMIT_NOFILE": limits.open_files,
        "RLIMIT_FSIZE": limits.file_mib << 20,
        "RLIMIT_MEMLOCK": LOCKED_BYTES,
        "RLIMIT_MSGQUEUE": 0,
        "RLIMIT_STACK": STACK_BYTES,
    }
    orders += [f"{name}={value}" for name, value in resources.items()]
    orders += [] if uid is None else [f"uid={uid}"]
    launcher = str(Path(__file__).with_name("launcher.py"))
    return [sys.executable, "-I", "-S", launcher, *orders, "--", *command]
