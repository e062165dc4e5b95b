"""Hostile programs in other languages: at the compiler, at the start, while they run, at the end.

For a language's folder there is a folder of programs and a table of its name; see c_family.toml.
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
from seamark.sandbox.languages import LANGUAGES, language_of
from seamark.sandbox.limits import COMPILING, Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded
from seamark.sandbox.probing.self_test import tried
from tests.hostile.conftest import LAYOUT, STEPS, limits_for
from tests.sandbox.host_compiler import zipped
from tests.sandbox.languages.folders import folder_of

pytestmark = pytest.mark.host

HERE = Path(__file__).parent
LANGUAGE_FOLDERS = dict.fromkeys(folder_of(language) for language in LANGUAGES.values())
TABLES = {
    folder: tomllib.loads((HERE / f"{folder}.toml").read_text(encoding="utf-8"))
    for folder in LANGUAGE_FOLDERS
    if (HERE / f"{folder}.toml").exists()  # test_registry.py demands it of each language
}
CASES = [(folder, name) for folder, table in TABLES.items() for name in sorted(table)]
MEMORY_MIB = {"matlab": 256}  # Octave has 180 MiB of address space by itself
COMPILER = replace(COMPILING, cpu_s=3.0)  # the bombs would use up any limit

Run = Callable[[str, str], Outcome]


@pytest.fixture(scope="module")
def run_program(isolation: IsolationLevel) -> Run:
    """Return a function that compiles and runs one program and returns its outcome."""

    def run_one(folder: str, file: str) -> Outcome:
        name, source = packed(folder, file)
        language = language_of(name)
        limits = limits_for(TABLES[folder][file])
        limits = replace(limits, memory_mib=MEMORY_MIB.get(folder, limits.memory_mib))
        if why := missing(language, isolation):
            pytest.skip(why)
        try:
            program = compiled(language, source, name, isolation=isolation, limits=COMPILER)
            return stepped(language, program, name, isolation, limits)
        except ProgramEnded as end:
            return end.outcome

    return run_one


def packed(folder: str, name: str) -> tuple[str, bytes]:
    """Return an upload: the file as it is, or an FMU with it as its source."""
    text = (HERE / folder / name).read_bytes()
    if folder != "fmu":
        return name, text
    common = HERE / folder / "common"
    members = {
        "modelDescription.xml": (common / "modelDescription.xml").read_bytes(),
        "sources/fmu.h": (common / "fmu.h").read_bytes(),
        "sources/model.c": (common / "model.c").read_bytes(),
        f"sources/{name}": text,
    }
    return f"{name.removesuffix('.c')}.fmu", zipped(members)


@cache
def missing(language: str, isolation: IsolationLevel) -> str:
    return tried(language, isolation).why_not


def stepped(
    language: str, program: bytes, name: str, isolation: IsolationLevel, limits: Limits
) -> Outcome:
    with Box(language, limits=limits, isolation=isolation) as box:
        box.load(program, name, {"kp": 0.5}, LAYOUT)
        box.reset({"index": 0})
        for step in range(STEPS):
            box.step([step / 20, 0.1, 0.2, 0.3, 5.0, 1.0])
        return box.finish()


@pytest.mark.parametrize("folder", TABLES)
def test_every_program_has_an_expectation_and_every_expectation_a_program(folder) -> None:
    assert {path.name for path in (HERE / folder).iterdir() if path.is_file()} == set(
        TABLES[folder]
    )


@pytest.mark.parametrize(("folder", "name"), CASES)
def test_a_hostile_program_ends_as_the_table_says(
    folder, name, run_program, isolation, secret
) -> None:
    expected = TABLES[folder][name]
    # Without control groups nothing counts for the whole box: it is stopped all the same, but the
    # verdict depends on how the program reacts to the refusal.
    named = expected.get("medium") if isolation is IsolationLevel.MEDIUM else None

    outcome = run_program(folder, name)

    assert outcome.verdict == (named or expected["verdict"]), outcome
    assert b"GOT" not in outcome.output
    assert re.search(expected.get("says", ""), outcome.sentence), outcome.sentence
    assert secret.encode() not in outcome.output
    assert len(outcome.output) < 5000
    assert not re.search(r"/tmp/|/box/native/runner.c:|\x1b", outcome.sentence + outcome.traceback)
