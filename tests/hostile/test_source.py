"""Sources that are not valid Python: written here, since tools would fail on files of them."""

import re

import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict

pytestmark = pytest.mark.host

LAYOUT = {"observation": [["t", 0]], "command": ["surge", "sway", "heave", "yaw_rate"]}
COLON_MISSING = b"class Controller:\n    def step(self, observation)\n        return [0, 0, 0, 0]\n"


@pytest.fixture
def end_of(isolation):
    def load(source: bytes, limits: Limits) -> Outcome:
        with Box(limits=limits, isolation=isolation) as box, pytest.raises(ProgramEnded) as end:
            box.load(source, "mine.py", {}, LAYOUT)
        return end.value.outcome

    return load


@pytest.mark.parametrize(
    ("source", "says"),
    [
        (COLON_MISSING, r"SyntaxError: .* \(line 2 of mine.py\)"),
        (b"class Controller:\ndef step(self): pass\n", r"IndentationError: .* \(line 2 of"),
        (b"if True:\n        x = 1\n\ty = 2\n", r"TabError|IndentationError"),
        (b"x = 1\x00\n", "null bytes"),
        (b"# -*- coding: nonsense -*-\n", "encoding"),
        ("name = 'é'\n".encode("latin-1"), "utf-8"),
        (b"x = " + b"(" * 500 + b")" * 500, "parentheses"),
        (b"x = " + b"-" * 200_000 + b"1\n", "Error"),
        (b"x = '''", "unterminated"),
        (b"\xff\xfe\x00", "Error"),
    ],
)
def test_a_text_that_is_no_python_is_a_compile_error_with_its_line(source, says, end_of) -> None:
    outcome = end_of(source, Limits())

    assert outcome.verdict is Verdict.COMPILE_ERROR, outcome
    assert re.search(says, outcome.sentence), outcome.sentence


def test_an_empty_text_is_told_what_a_program_needs(end_of) -> None:
    outcome = end_of(b"", Limits())

    assert outcome.verdict is Verdict.USER_ERROR
    assert "class Controller" in outcome.sentence


def test_a_text_over_the_limit_never_reaches_the_interpreter(end_of) -> None:
    outcome = end_of(b"#" * 2048, Limits(source_kib=1))

    assert outcome.verdict is Verdict.COMPILE_ERROR
    assert "limit is 1 KiB" in outcome.sentence
