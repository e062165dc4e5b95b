"""Hostile programs in other languages: at the compiler, at the start, while they run, at the end.

A folder of programs and a table of the same name for each kind; see native.toml.
"""

import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import language_of
from seamark.sandbox.limits import COMPILING, Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded
from seamark.sandbox.probing.self_test import why_not
from tests.hostile.conftest import LAYOUT, STEPS, limits_for
from tests.sandbox.host_compiler import zipped

pytestmark = pytest.mark.host

HERE = Path(__file__).parent
KINDS = ("native", "octave", "fmu")
TABLES = {
    kind: tomllib.loads((HERE / f"{kind}.toml").read_text(encoding="utf-8")) for kind in KINDS
}
CASES = [(kind, name) for kind in KINDS for name in sorted(TABLES[kind])]
MEMORY_MIB = {"octave": 256}  # it has 180 MiB of address space by itself
COMPILER = replace(COMPILING, cpu_s=3.0)  # the bombs would take all that they are given

Run = Callable[[str, str], Outcome]


@pytest.fixture(scope="module")
def run_native(isolation: IsolationLevel) -> Run:
    """Return a function that compiles and runs one program and tells how it ended."""

    def run_one(kind: str, file: str) -> Outcome:
        name, source = packed(kind, file)
        language = language_of(name)
        limits = limits_for(TABLES[kind][file])
        limits = replace(limits, memory_mib=MEMORY_MIB.get(kind, limits.memory_mib))
        if why := missing(language, isolation):
            pytest.skip(why)
        try:
            program = compiled(language, source, name, isolation=isolation, limits=COMPILER)
            return stepped(language, program, name, isolation, limits)
        except ProgramEnded as end:
            return end.outcome

    return run_one


def packed(kind: str, name: str) -> tuple[str, bytes]:
    """Return an upload: the file as it is, or an FMU with it as its source."""
    text = (HERE / kind / name).read_bytes()
    if kind != "fmu":
        return name, text
    common = HERE / kind / "common"
    members = {
        "modelDescription.xml": (common / "modelDescription.xml").read_bytes(),
        "sources/fmu.h": (common / "fmu.h").read_bytes(),
        "sources/model.c": (common / "model.c").read_bytes(),
        f"sources/{name}": text,
    }
    return f"{name.removesuffix('.c')}.fmu", zipped(members)


@cache
def missing(language: str, isolation: IsolationLevel) -> str:
    return why_not(language, isolation)


def stepped(
    language: str, program: bytes, name: str, isolation: IsolationLevel, limits: Limits
) -> Outcome:
    with Box(language, limits=limits, isolation=isolation) as box:
        box.load(program, name, {"kp": 0.5}, LAYOUT)
        box.reset({"index": 0})
        for tick in range(STEPS):
            box.step([tick / 20, 0.1, 0.2, 0.3, 5.0, 1.0])
        return box.finish()


@pytest.mark.parametrize("kind", KINDS)
def test_every_program_has_an_expectation_and_every_expectation_a_program(kind) -> None:
    assert {path.name for path in (HERE / kind).iterdir() if path.is_file()} == set(TABLES[kind])


@pytest.mark.parametrize(("kind", "name"), CASES)
def test_a_hostile_program_ends_as_the_table_says(
    kind, name, run_native, isolation, secret
) -> None:
    expected = TABLES[kind][name]
    # Without control groups nobody counts for the box: stopped all the same, but named by what the
    # program made of the refusal.
    named = expected.get("medium") if isolation is IsolationLevel.MEDIUM else None

    outcome = run_native(kind, name)

    assert outcome.verdict == (named or expected["verdict"]), outcome
    assert b"GOT" not in outcome.output
    assert re.search(expected.get("says", ""), outcome.sentence), outcome.sentence
    assert secret.encode() not in outcome.output
    assert len(outcome.output) < 5000
    assert not re.search(r"/tmp/|/box/native/runner.c:|\x1b", outcome.sentence + outcome.traceback)
