"""Calls hostile programs outside the box: there they must get through, or a test proves nothing.

A caller without any guard calls the program as root, on a copy of the machine (callers/init.py), in
a control group with bounds of its own. What is seen: what the program prints, and what its caller
says of it. It ends as soon as the expected is seen.
"""

import contextlib
import json
import os
import re
import select
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from seamark.sandbox.isolation.cgroups import ControlGroup
from seamark.sandbox.languages import c_family, matlab
from seamark.sandbox.limits import Limits
from tests.hostile.corpus import HERE, Case

CALLERS = HERE / "callers"
RUNNERS = (
    Path(c_family.__file__).with_name("runner.c"),
    Path(matlab.__file__).with_name("inside") / "runner.m",
)
HEADER = Path(c_family.__file__).with_name("seamark.h")
BOUNDS = Limits(cpu_s=60.0, wall_s=60.0, memory_mib=640, processes=100)
ENDS_AFTER_S = 60.0  # [s] what was to be seen by then was not
LOOKS_EVERY_MS = 30  # at what a program takes, while it prints nothing
KILLED_WITHIN_MS = 1000
WAITS_S = 1.5  # [s] with less than that much CPU time, longer than any limit of an answer


@dataclass
class Seen:
    """What a program printed outside the box, and what its caller says of it."""

    text: str = ""

    def note(self, text: str) -> None:
        self.text += f"\nCALLER: {text}\n"


class Excess:
    """What a program takes beyond the limits of the tests' boxes."""

    def __init__(self, group: ControlGroup, limits: Limits) -> None:
        self._group, self._limits = group, limits
        self._noted: set[str] = set()
        self._calls = 0
        self._since, self._before_s = time.monotonic(), 0.0  # of the last call

    def notes(self, printed: int, *, calls: int) -> Iterator[str]:
        """Yield what is new: of the time and CPU time since the last call.

        The compiler is called before the program: neither counts for the other.
        """
        if calls > self._calls or not calls:
            self._calls = calls
            self._since, self._before_s = time.monotonic(), self._group.cpu_s()
            return
        limits, waited_s = self._limits, time.monotonic() - self._since
        cpu_s = self._group.cpu_s() - self._before_s
        every = {
            "more CPU time": cpu_s > limits.cpu_s,
            "more memory": self._group.memory_mib() > limits.memory_mib,
            # The bound of the group, which is higher, may end a program between two looks.
            "more processes": len(self._group.threads()) > limits.processes + 10
            or self._group.out_of_processes(),
            "a longer log than is kept": printed > limits.output_kib << 10,
            "a longer log": printed > limits.output_max_mib << 20,
            "its caller's time": waited_s > WAITS_S and cpu_s < waited_s / 2,
        }
        for name, exceeds in every.items():
            if exceeds and name not in self._noted:
                self._noted.add(name)
                yield f"takes {name}"


@contextlib.contextmanager
def machines() -> Iterator[socket.socket]:
    """Yield where to ask for a copy of the machine (callers/init.py)."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    # Without buffers: what a program has printed is seen though a signal ends it.
    command = [sys.executable, "-u", "-s", "-P", str(CALLERS / "init.py")]
    environment = {"SEAMARK_SECRET_KEY": "do-not-tell", "OPENBLAS_NUM_THREADS": "1"}
    with subprocess.Popen(command, stdin=theirs, env=os.environ | environment), ours:
        theirs.close()
        yield ours


def outside(case: Case, limits: Limits, folder: Path, machines: socket.socket) -> str:
    """Return what is seen of a program, as far as it was needed to see what the table says.

    `limits` are those of the box: what goes beyond is seen.
    """
    attack, overlay = folder / "attack", folder / "overlay"
    overlay.mkdir()
    for runner in RUNNERS:  # some programs are interested in them
        box = attack / "box" / ("octave" if runner.suffix == ".m" else "native")
        box.mkdir(parents=True)
        shutil.copy(runner, box)
    seen = Seen()
    group = ControlGroup(BOUNDS)
    try:
        message = [group.procs_files(), str(overlay), str(attack), *command_of(case, attack)]
        reading, writing = os.pipe()
        with open(reading, "rb"):
            socket.send_fds(machines, [json.dumps(message).encode()], [writing])
            os.close(writing)
            watch(reading, seen, Excess(group, limits), re.compile(case.expected["outside"]))
            group.kill()
            wait_for_the_end(reading)
    finally:
        group.kill()
        group.remove()
    return seen.text


def watch(reading: int, seen: Seen, excess: Excess, wanted: re.Pattern) -> None:
    """Read and measure until what is wanted is seen, or nothing follows."""
    poll = select.poll()
    poll.register(reading, select.POLLIN)
    printed = 0
    until = time.monotonic() + ENDS_AFTER_S
    while time.monotonic() < until and not wanted.search(seen.text):
        data = b" "
        if poll.poll(LOOKS_EVERY_MS):
            data = os.read(reading, 1 << 20)
            printed += len(data)
            seen.text = (seen.text + data.decode("utf-8", "replace"))[-100_000:]
        calls = seen.text.count("CALLER: calls") or int(printed > 10_000)
        for note in excess.notes(printed, calls=calls):
            seen.note(note)
        if not data:
            return


def wait_for_the_end(reading: int) -> None:
    """Wait until all processes that print have ended: removing the group would ask 20 times."""
    poll = select.poll()
    poll.register(reading, select.POLLIN)
    while poll.poll(KILLED_WITHIN_MS) and os.read(reading, 1 << 20):
        pass


def command_of(case: Case, attack: Path) -> list[str]:
    """Return the command that calls a program; what it needs is in the folder."""
    role, suffix = case.role, case.path.suffix
    first = b"1;\n" if suffix == ".m" else b""  # Octave: a script, not one function
    (attack / f"program{suffix}").write_bytes(first + case.source)
    if suffix == ".py":
        shutil.copy(CALLERS / "caller.py", attack)
        return ["/attack/caller.py", "/attack/program.py", json.dumps(case.config), role]
    if suffix == ".m":
        shutil.copy(CALLERS / "caller.m", attack)
        octave = "/usr/bin/octave-cli", "--norc", "--no-history", "--no-gui", "--no-line-editing"
        return [*octave, "--quiet", "/attack/caller.m", "/attack/program.m", role]
    return compiling(case, attack, suffix)


def compiling(case: Case, attack: Path, suffix: str) -> list[str]:
    """Return the command that compiles a program with its caller, and starts it."""
    kind = f"-D{case.role.upper()}" if not case.name.startswith("model_") else "-DMODEL"
    caller = "caller_of_fmu.c" if case.folder == "fmu" else "caller.c"
    (attack / "caller.o").write_bytes(caller_object(caller, kind))
    parts = ["program.o", "caller.o"]
    if case.folder == "fmu":
        shutil.copytree(HERE / "fmu" / "common", attack, dirs_exist_ok=True)
        parts += ["model.c"]
    else:
        shutil.copy(HEADER, attack)
    compiler = "g++" if suffix == ".cpp" else "gcc"
    steps = (
        "echo && echo CALLER: calls",  # the compiler: what it takes is seen, too
        f"{compiler} -O1 -w -I. -c program{suffix} -o program.o",
        "echo && echo CALLER: the compiler takes $(stat -c %s program.o) bytes",
        f"{compiler} {' '.join(parts)} -o program -lm",
        "exec ./program",
    )
    return ["/bin/sh", "-c", " && ".join(steps)]


@cache
def caller_object(caller: str, kind: str) -> bytes:
    """Return what a caller in C is compiled to, once for all programs."""
    command = ["gcc", *kind.split(), f"-I{HEADER.parent}", "-c", str(CALLERS / caller)]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([*command, "-o", f"{folder}/caller.o"], check=True)
        return Path(folder, "caller.o").read_bytes()
