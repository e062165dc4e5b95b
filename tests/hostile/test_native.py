"""Hostile programs in C and C++: at the compiler, at the start, while they run, at the end."""

import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from sandbox.box import Box
from sandbox.compilation import compiled
from sandbox.languages import language_of
from sandbox.level import Level
from sandbox.limits import COMPILING
from sandbox.outcome import Outcome, ProgramEnded
from sandbox.self_test import why_not
from tests.hostile.conftest import LAYOUT, LIMITS, STEPS

pytestmark = pytest.mark.host

TABLE = tomllib.loads(Path(__file__).with_name("native.toml").read_text(encoding="utf-8"))
PROGRAMS = Path(__file__).with_name("native")
COMPILER = replace(COMPILING, cpu_s=3.0)  # the bombs would take all that they are given

Run = Callable[[str], Outcome]


@pytest.fixture(scope="module")
def run_native(level: Level) -> Run:
    """Return a function that compiles and runs one program and tells how it ended."""
    if why := why_not("c++", level):
        pytest.skip(why)

    def run_one(name: str) -> Outcome:
        language = language_of(name)
        source = (PROGRAMS / name).read_bytes()
        try:
            program = compiled(language, source, name, level=level, limits=COMPILER)
            return stepped(language, program, name, level)
        except ProgramEnded as end:
            return end.outcome

    return run_one


def stepped(language: str, program: bytes, name: str, level: Level) -> Outcome:
    with Box(language, limits=LIMITS, level=level) as box:
        box.load(program, name, {"kp": 0.5}, LAYOUT)
        box.reset({"index": 0})
        for tick in range(STEPS):
            box.step([tick / 20, 0.1, 0.2, 0.3, 5.0, 1.0])
        return box.finish()


def test_every_program_has_an_expectation_and_every_expectation_a_program() -> None:
    assert {path.name for path in PROGRAMS.iterdir()} == set(TABLE)


@pytest.mark.parametrize("name", sorted(TABLE))
def test_a_hostile_program_ends_as_the_table_says(name, run_native, level, secret) -> None:
    expected = TABLE[name]
    # Without control groups nobody counts for the box: stopped all the same, but named by what the
    # program made of the refusal.
    named = expected.get("medium") if level is Level.MEDIUM else None

    outcome = run_native(name)

    assert outcome.verdict == (named or expected["verdict"]), outcome
    assert b"GOT" not in outcome.output
    assert re.search(expected.get("says", ""), outcome.sentence), outcome.sentence
    assert secret.encode() not in outcome.output
    assert len(outcome.output) < 5000
    assert not re.search(r"/tmp/|/box/native/runner.c:|\x1b", outcome.sentence + outcome.traceback)
