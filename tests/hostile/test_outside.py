"""Outside the box every hostile program gets through: what holds it in the box is the box."""

import os
import re
import socket
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.outcome import Verdict
from tests.hostile.conftest import COMPILER, LIMITS, limits_for
from tests.hostile.control import machines, outside
from tests.hostile.corpus import CASES, FRAMES, Case

pytestmark = pytest.mark.host

each_case = pytest.mark.parametrize("program", CASES, ids=str)
NOT_IN_THIS_KERNEL = re.compile(r".*\[Errno (?:38|97)\].*")  # ENOSYS, EAFNOSUPPORT


@pytest.fixture(scope="module")
def copies() -> Iterator[socket.socket]:
    with machines() as requests:
        yield requests


@each_case
def test_every_program_says_what_is_seen_outside_the_box(program) -> None:
    assert program.expected["outside"]


@each_case
def test_outside_the_box_a_hostile_program_gets_through(
    program, isolation, tmp_path, copies
) -> None:
    if os.geteuid() != 0 or isolation is not IsolationLevel.STRONG:
        pytest.skip("outside the box it needs root, and control groups that hold it")
    expected = program.expected

    compiles = program.name.startswith("compile_")
    limits = replace(limits_for(program), cpu_s=(COMPILER if compiles else LIMITS).cpu_s)

    seen = outside(program, limits, tmp_path, copies)

    if "absent" in expected and (refused := NOT_IN_THIS_KERNEL.search(seen)):
        pytest.skip(f"{program}: this kernel is without {expected['absent']}: {refused[0]}")
    assert re.search(expected["outside"], seen), seen


@dataclass(frozen=True)
class Honest(Case):
    """A program that does nothing wrong."""

    text: bytes = b""

    @property
    def expected(self) -> dict[str, str]:
        return {"outside": "exited with", "verdict": Verdict.OK}

    @property
    def source(self) -> bytes:
        return self.text

    @property
    def path(self) -> Path:
        return Path(self.name)


HONEST = [
    Honest(
        "python",
        "honest.py",
        (FRAMES / "controller.py").read_bytes()
        + b"""
HELD = ()
globals()[""] = lambda observation: None
""",
    ),
    Honest(
        "c_family",
        "honest.c",
        b"""#include "seamark.h"
int seamark_step(const seamark_observation *observation, seamark_command *command) { return 0; }
""",
    ),
    Honest("fmu", "honest.c", b'#include "fmu.h"'),
    Honest(
        "matlab",
        "honest.m",
        b"""
function [command, state] = controller_step(state, observation)
    command = [0, 0, 0, 0];
end
""",
    ),
    Honest(
        "detectors",
        "honest.py",
        b"\ndef attack(image):\n    return None\n"
        + b"".join((FRAMES / name).read_bytes() for name in ("answers.py", "detector.py")),
    ),
    Honest(
        "detectors",
        "honest.c",
        (FRAMES / "detector.c").read_bytes()
        + b"static int attack(const seamark_image *image, seamark_detection *found) { return 1; }",
    ),
    Honest(
        "detectors",
        "honest.m",
        b"""
function [found, state] = detector_detect(state, image)
    found = detection();
end
"""
        + (FRAMES / "detector.m").read_bytes(),
    ),
]


@pytest.mark.parametrize("program", HONEST, ids=str)
def test_an_honest_program_is_seen_to_do_nothing_outside_the_box(
    program, isolation, tmp_path, copies
) -> None:
    if os.geteuid() != 0 or isolation is not IsolationLevel.STRONG:
        pytest.skip("outside the box it needs root, and control groups that hold it")

    limits = replace(limits_for(program), cpu_s=LIMITS.cpu_s)

    seen = outside(program, limits, tmp_path, copies)

    assert "CALLER: finished" in seen
    assert not re.search("GOT|takes more|longer log|took|arrived|left|changed|closed", seen), seen
