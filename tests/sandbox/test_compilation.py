"""Programs in C and C++: compiler messages, inputs and output."""

import platform
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES, language_of
from seamark.sandbox.languages.c_family.host import gcc_runtime, our_objects
from seamark.sandbox.limits import COMPILING, Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict
from seamark.sandbox.probing.self_test import tried
from tests.services.languages import skip_without

pytestmark = pytest.mark.host

LAYOUT = {
    "observation": [["t", 0], ["new_field", 2], ["error", 3], ["target_visible", 0], ["thrust", 5]],
    "booleans": ["target_visible"],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
VALUES = [0.25, 8.0, 9.0, 1.0, 2.0, 3.0, 1.0, 0.1, 0.2, 0.3, 0.4, 0.5]
CONFIG = {
    "note": 'a "kp": 7.0, {in} a text',
    "levels": [0.0, {"kp": 5.0}],
    "kp": 0.1,
    "small": 1e-300,
    "on": True,
    "whole": -3,
    "accents": "é\\",
}
PROGRAM = """\
#include <stdio.h>
#include "seamark.h"
%s
int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    %s
    return 0;
}
"""


@pytest.fixture(autouse=True, scope="module")
def _compiler(isolation: IsolationLevel) -> None:
    skip_without("c++", isolation)


def printed(
    isolation: IsolationLevel, *, before: str = "", step: str = "", name: str = "mine.c"
) -> Outcome:
    """Return how a program ended after one level of one step."""
    source = (PROGRAM % (before, step)).encode()
    language = str(language_of(name))
    program = compiled(language, source, name, isolation=isolation)
    with Box(language, limits=Limits(), isolation=isolation) as box:
        box.load(program, name, CONFIG, LAYOUT)
        box.reset({"index": 2, "count": 5, "duration_s": 120.0, "dt": 0.05, "t": 240.0})
        box.step(VALUES)
        return box.finish()


@pytest.mark.parametrize("language", ["c", "c++"])
def test_the_self_test_answers_half_the_error(language, isolation) -> None:
    assert tried(language, isolation).why_not == ""
    assert LANGUAGES[language].compiler is not None


SEEN = {  # expression -> what it is
    "observation->t": "0.25",
    "observation->error[2]": "3",
    "(double)observation->target_visible": "1",
    "observation->thrust[4]": "0.5",
    "observation->thrust[5]": "0",
    "(double)observation->thrusters": "5",
    "observation->depth": "0",
    'seamark_config_number("kp", 9.0)': "0.10000000000000001",
    'seamark_config_number("small", 9.0)': "1e-300",
    'seamark_config_number("on", 9.0)': "1",
    'seamark_config_number("whole", 9.0)': "-3",
    'seamark_config_number("note", 9.0)': "9",
    'seamark_config_number("levels", 9.0)': "9",
    'seamark_config_number("missing", 9.0)': "9",
    "(double)(seamark_config_json()[0] == '{')": "1",
}


@pytest.fixture(scope="module")
def seen(isolation: IsolationLevel) -> dict[str, str]:
    """What one program prints of each expression."""
    step = "".join(f'printf("%.17g\\n", {expression});' for expression in SEEN)
    return dict(zip(SEEN, printed(isolation, step=step).output.decode().splitlines(), strict=True))


@pytest.mark.parametrize("expression", SEEN)
def test_a_program_sees_fields_by_name_and_numbers_exactly(expression, seen) -> None:
    assert seen[expression] == SEEN[expression]


def test_a_program_is_told_its_level(isolation) -> None:
    before = """
static seamark_level seen;
void seamark_reset(const seamark_level *level) { seen = *level; }
"""
    step = 'printf("%d %d %g %g %g\\n", seen.index, seen.count, seen.duration_s, seen.dt, seen.t);'

    assert printed(isolation, before=before, step=step).output == b"2 5 120 0.05 240\n"


def test_lines_are_seen_as_soon_as_they_are_printed_even_by_iostreams(isolation) -> None:
    source = PROGRAM % (
        "#include <iostream>",
        'std::cout << "a\\n"; puts("b"); std::cerr << "c\\n";',
    )
    program = compiled("c++", source.encode(), "mine.cpp", isolation=isolation)

    with Box("c++", limits=Limits(), isolation=isolation) as box:
        box.load(program, "mine.cpp", {}, LAYOUT)
        box.step(VALUES)
        assert box.take_output() == b"a\nb\nc\n"


@pytest.mark.parametrize("name", ["mine.c", "-o.c", "my file.c", "MINE.C", "größe.c", "mine.cc"])
def test_the_compiler_names_the_uploaded_file_and_its_line(name, isolation) -> None:
    with pytest.raises(ProgramEnded) as end:
        printed(isolation, step="nothing();", name=name)

    outcome = end.value.outcome
    assert outcome.verdict is Verdict.COMPILE_ERROR
    assert f"{name}:6:5: " in outcome.sentence + outcome.traceback
    assert "/tmp" not in outcome.traceback


def test_a_program_without_a_step_is_told_what_it_needs(isolation) -> None:
    program = compiled("c", b"int x;\n", "mine.c", isolation=isolation)
    with Box("c", limits=Limits(), isolation=isolation) as box, pytest.raises(ProgramEnded) as end:
        box.load(program, "mine.c", {}, LAYOUT)

    outcome = end.value.outcome
    assert outcome.verdict is Verdict.COMPILE_ERROR
    assert "mine.c does not define seamark_step: a controller defines int" in outcome.sentence
    assert "seamark.h" in outcome.sentence


def test_a_source_in_python_is_not_compiled(isolation) -> None:
    assert compiled("python", b"text", "mine.py", isolation=isolation) == b"text"


def test_the_same_source_gives_the_same_program(isolation) -> None:
    programs = {
        compiled("c", (PROGRAM % ("", "")).encode(), "a.c", isolation=isolation) for _ in range(2)
    }

    assert len(programs) == 1


def test_bytes_that_are_not_a_program_are_the_users_error(isolation) -> None:
    with Box("c", limits=Limits(), isolation=isolation) as box, pytest.raises(ProgramEnded) as end:
        box.load(b"no program", "mine.c", {}, LAYOUT)

    assert end.value.outcome.verdict is Verdict.USER_ERROR
    assert "cannot be started" in end.value.outcome.sentence


def test_no_program_larger_than_the_limit_is_started(isolation) -> None:
    limits = Limits(binary_mib=1)
    with Box("c", limits=limits, isolation=isolation) as box, pytest.raises(ProgramEnded) as end:
        box.load(b"x" * (1 << 21), "mine.c", {}, LAYOUT)

    assert "limit is 1024 KiB" in end.value.outcome.sentence


def test_the_self_tests_report_what_programs_find(isolation: IsolationLevel) -> None:
    python = {one.name: one.version for one in tried("python", isolation).contents}
    cpp = {one.name: one.kind for one in tried("c++", isolation).contents}

    assert python["Python"] == platform.python_version()
    assert python["NumPy"] == np.__version__
    assert {"SciPy", "OpenCV", "ONNX Runtime"} <= set(python)
    assert cpp["GCC"] == "compiler"
    assert cpp["GNU C library"] == "library"


CRASHES = {
    "SIGSEGV": "int *nowhere = 0;\n    *(volatile int *)nowhere = 3;",
    "SIGFPE": "volatile int zero = 0;\n    command->surge = 7 / zero;",
    "SIGABRT": "(void)0;\n    abort();",
}


@pytest.mark.parametrize(
    ("signal", "name"), [("SIGSEGV", "mine.c"), ("SIGFPE", "mine.c"), ("SIGABRT", "mine.cpp")]
)
def test_a_crash_is_reported_with_its_line(
    signal: str, name: str, isolation: IsolationLevel
) -> None:
    with pytest.raises(ProgramEnded) as end:
        printed(isolation, before="#include <stdlib.h>", step=CRASHES[signal], name=name)

    assert end.value.outcome.verdict is Verdict.USER_ERROR
    assert end.value.outcome.sentence.startswith(f"The program was ended by {signal}")
    assert end.value.outcome.sentence.endswith(f"in seamark_step (line 7 of {name})")


def test_endless_recursion_is_reported_with_its_line(isolation: IsolationLevel) -> None:
    deep = "int deep(int n) { volatile int a[500] = {n}; return a[0] ? deep(n + 1) + a[1] : 0; }"

    with pytest.raises(ProgramEnded) as end:
        printed(isolation, before=deep, step="command->surge = deep(1);")

    assert "SIGSEGV" in end.value.outcome.sentence
    assert end.value.outcome.sentence.endswith("in deep (line 3 of mine.c)")


def test_a_program_is_the_same_where_our_part_of_it_is_compiled_with_each(
    isolation: IsolationLevel, tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    runtime = gcc_runtime("gcc")
    kept = set(our_objects().values())
    nothing_kept = tuple(mount for mount in runtime.mounts if mount.source not in kept)
    source = (PROGRAM % ("", "")).encode()
    programs = []
    for mounts in (runtime.mounts, nothing_kept):
        with Box(
            "c", limits=COMPILING, isolation=isolation, runtime=replace(runtime, mounts=mounts)
        ) as box:
            box.load(source, "mine.c", {}, LAYOUT)
            programs.append(box.finish().output)

    assert len(kept) == len(runtime.mounts) - len(nothing_kept) == 2
    assert programs[0] == programs[1] != b""
    assert our_objects(tmp_path / "file" / "no folder") == {}
