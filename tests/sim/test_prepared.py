"""Programs of tests that are forks run as in an interpreter of their own."""

from pathlib import Path

import pytest

from tests.services.prepared import KINDS, printed, run

STARTED = "print(open('/proc/self/environ').read().replace(chr(0), chr(10)))"
PROCESSOR = """
import cv2, numba, numpy
numpy_has = numpy._core._multiarray_umath.__cpu_features__
print(numba.config.CPU_NAME, numpy_has["X86_V3"], cv2.checkHardwareSupport(11))  # CV_CPU_AVX2
"""
COMPUTED = """
from seamark.sim.numerics.libm import sin
print(len(sin.signatures))
sin(0.5)
print(len(sin.signatures))
"""


@pytest.mark.parametrize("kind", KINDS)
def test_an_interpreter_was_started_with_what_is_read_only_then(kind: str) -> None:
    started = printed(STARTED, on=kind).splitlines()

    assert {f"{name}={value}" for name, value in KINDS[kind].items()} <= set(started)


def test_on_the_oldest_processor_no_library_finds_a_newer_one() -> None:
    assert printed(PROCESSOR, on="oldest").split() == ["generic", "False", "False"]


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "warm"])
def test_nothing_of_a_program_is_there_in_the_next(kind: str) -> None:
    assert [printed(COMPUTED, on=kind).split() for _ in range(2)] == [["0", "1"]] * 2


def test_a_program_has_its_arguments_its_folder_and_its_environment(tmp_path: Path) -> None:
    program = "import os, sys; print(sys.argv, os.getcwd(), os.environ['OF_TEST'], __name__)"

    done = run(program, "a", "b", folder=tmp_path, environment={"OF_TEST": "here"})

    assert done.stdout == f"['-c', 'a', 'b'] {tmp_path} here __main__\n"


@pytest.mark.parametrize(
    ("program", "code", "errors"),
    [
        ("1 / 0", 1, "ZeroDivisionError: division by zero\n"),
        ("raise SystemExit", 0, ""),
        ("raise SystemExit(3)", 3, ""),
        ("raise SystemExit('no')", 1, "no\n"),
        ("import os; os.kill(os.getpid(), 9)", -9, ""),
    ],
)
def test_how_a_program_ends_is_told(program: str, code: int, errors: str) -> None:
    done = run(program)

    assert done.returncode == code
    assert done.stderr.endswith(errors)
    assert bool(done.stderr) == bool(errors)


def test_a_program_that_fails_prints_nothing_for_a_test() -> None:
    with pytest.raises(AssertionError, match="ZeroDivisionError"):
        printed("print(1)\n1 / 0")
