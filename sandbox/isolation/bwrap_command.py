"""How a box is started: the command lines of bubblewrap and of its launcher.

Namespaces: all. Root: a new tmpfs with what the language needs, read-only, without /proc. Only
/tmp and /dev/shm are writable, both of limited size. bubblewrap's own `--dev` would be a writable
tmpfs of half the memory; instead, five device nodes are bound into a small one.
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

from seamark.sandbox.isolation.readable_copies import readable_by_all
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.runtime import LIBRARIES, Runtime

DEVICES = ("null", "zero", "full", "random", "urandom")
DEV_BYTES = 65536  # [B] size of /dev
LOCKED_BYTES = 65536  # [B] RLIMIT_MEMLOCK
STACK_BYTES = 8 << 20  # [B] RLIMIT_STACK
INNER_PROCESSES = 1  # bubblewrap's inner init, in the same namespace
FIRST_DESCRIPTOR = 3  # in the box: the protocol's socket, after the standard streams
IMAGES_DESCRIPTOR = 4
CPU_GRACE_S = 10  # [s] RLIMIT_CPU counts the start too; it is the backstop for a worker that hangs

_ROOT_LIBRARIES = (Path("/lib"), Path("/lib64"))

NAMESPACES = ("user", "ipc", "pid", "net", "uts", "cgroup")


@dataclass(frozen=True, slots=True)
class Descriptors:
    """Descriptors that bubblewrap inherits; it closes its own two before it starts the program."""

    protocol: int  # the program keeps this one
    status: int  # bubblewrap reports the pid of its inner init and the exit code here
    seccomp: int | None  # the system call filter
    images: int | None = None  # the program keeps this one if it is given images

    def inherited(self) -> tuple[int, ...]:
        """Return all of them; those of the program come first."""
        every = (self.protocol, self.images, self.status, self.seccomp)
        return tuple(number for number in every if number is not None)

    def inside(self) -> Self:
        """Return the numbers that the launcher gives them.

        They are the same in every run and do not reveal how many files the worker has open.
        """
        moved = dict(zip(self.inherited(), count(FIRST_DESCRIPTOR), strict=False))
        return type(self)(
            protocol=moved[self.protocol],
            status=moved[self.status],
            seccomp=None if self.seccomp is None else moved[self.seccomp],
            images=None if self.images is None else moved[self.images],
        )


def bubblewrap() -> str:
    """Return the path of bwrap; SandboxBroken with the remedy if it is missing."""
    path = shutil.which("bwrap", path=os.environ.get("PATH", "/usr/bin:/bin"))
    if path is None:
        raise SandboxBroken("bubblewrap is not installed (apt-get install bubblewrap)")
    return path


def bwrap_command(
    runtime: Runtime,
    limits: Limits,
    descriptors: Descriptors,
    *,
    limit_inside: bool,
    namespaces: Sequence[str] = NAMESPACES,
) -> list[str]:
    """Return bubblewrap's command line.

    `descriptors` are those inside the box. Only tests use fewer `namespaces`. With `limit_inside`
    the runner limits processes and memory itself, because no control group does.
    """
    command = [bubblewrap(), *(f"--unshare-{name}" for name in namespaces)]
    command += ["--hostname", "sandbox"] if "uts" in namespaces else []
    command += ["--disable-userns", "--uid", "1000", "--gid", "1000"]
    command += ["--die-with-parent", "--new-session", "--cap-drop", "ALL", "--clearenv"]
    command += ["--json-status-fd", str(descriptors.status)]
    for name, value in runtime.environment.items():
        command += ["--setenv", name, value]
    command += _libraries()
    for mount in runtime.mounts:
        command += ["--ro-bind", str(readable_by_all(mount.source)), mount.target]
    command += _writable(limits)
    command += ["--remount-ro", "/", "--chdir", "/tmp"]  # noqa: S108  (inside the box)
    if descriptors.seccomp is not None:
        command += ["--seccomp", str(descriptors.seccomp)]
    processes = limits.processes + INNER_PROCESSES if limit_inside else 0
    memory_mib = limits.memory_mib if limit_inside else 0
    numbers = (descriptors.protocol, processes, memory_mib)
    return [*command, "--", *runtime.command, *map(str, numbers)]


def library_folders() -> list[Path]:
    """Return the folders of the system's libraries, which every box sees."""
    folders = [LIBRARIES, Path("/usr/lib64"), *_ROOT_LIBRARIES]
    links = [folder for folder in _ROOT_LIBRARIES if folder.is_symlink()]
    return [folder for folder in folders if folder.is_dir() and folder not in links]


def _libraries() -> Iterator[str]:
    """Yield the options for the system's libraries: no programs, no /etc, no /home."""
    for folder in library_folders():
        yield from ("--ro-bind", str(folder), str(folder))
    for link in _ROOT_LIBRARIES:
        if link.is_symlink():
            yield from ("--symlink", os.readlink(link), str(link))


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
    cgroups: list[str],
    uid: int | None,
    core: int | None,
) -> list[str]:
    """Return the command line of the launcher that becomes bubblewrap."""
    steps = [f"descriptors={','.join(map(str, (FIRST_DESCRIPTOR, *inherited)))}"]
    steps += [f"cgroup={file}" for file in cgroups]
    steps += [] if core is None else [f"core={core}"]
    resources = {
        "RLIMIT_CORE": 1,  # [B] no core dump, and no handler of them (argument_rules.py)
        "RLIMIT_CPU": math.ceil(limits.cpu_s) + CPU_GRACE_S,
        "RLIMIT_NOFILE": limits.open_files,
        "RLIMIT_FSIZE": limits.file_mib << 20,
        "RLIMIT_MEMLOCK": LOCKED_BYTES,
        "RLIMIT_MSGQUEUE": 0,
        "RLIMIT_STACK": STACK_BYTES,
    }
    steps += [f"{name}={value}" for name, value in resources.items()]
    steps += [] if uid is None else [f"uid={uid}"]
    launcher = str(Path(__file__).with_name("launcher.py"))
    return [sys.executable, "-I", "-S", launcher, *steps, "--", *command]
