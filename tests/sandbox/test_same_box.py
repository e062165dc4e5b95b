"""What a box shows a program depends on nothing that its owner could choose beside what is hashed.

Whoever knows the water of a submission could otherwise tell the same program in a second run.
"""

import json
import os
import time
from pathlib import Path

import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded
from tests.sandbox.conftest import LAYOUT, VALUES, program
from tests.services.languages import skip_without

pytestmark = pytest.mark.host

PYTHON = b"""
import inspect
import sys

print(__file__, __name__, sys.argv, sys.orig_argv, inspect.currentframe().f_code.co_filename)
""" + program()
C = b"""
#define _GNU_SOURCE
#include <errno.h>
#include <stdio.h>
#include "seamark.h"
int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    printf("%s %s\\n", __FILE__, program_invocation_name);
    return 0;
}
"""
MATLAB = b"""
function [command, state] = controller_step(state, observation)
    printf("%s %s\\n", mfilename("fullpath"), program_invocation_name());
    command = [0, 0, 0, 0];
end
"""
VIEW = Path(__file__).with_name("view_of_box.py").read_bytes()
# What differs from box to box, and nobody can choose: it could make a program throw dice, no more.
DICE = {"clock", "random", "inode"}


@pytest.mark.parametrize(
    ("language", "source"),
    [("python", PYTHON), ("c", b"#define _GNU_SOURCE\n" + C), ("matlab", MATLAB)],
)
def test_a_program_does_not_learn_what_its_owner_calls_it(
    language: str, source: bytes, isolation: IsolationLevel
) -> None:
    skip_without(language, isolation)
    suffix = LANGUAGES[language].suffixes[0]

    one, other = (_printed(language, source, f"{name}{suffix}", isolation) for name in "ab")

    assert one == other != ""


def test_its_owner_reads_the_own_name_of_the_file_in_errors(isolation: IsolationLevel) -> None:
    with Box(limits=Limits(), isolation=isolation) as box, pytest.raises(ProgramEnded) as end:
        box.load(b"raise ValueError(__file__)", "mine.py", {}, LAYOUT)

    assert end.value.outcome.sentence == "ValueError: mine.py (line 1 of mine.py)"
    assert 'File "mine.py", line 1' in end.value.outcome.traceback


def test_a_box_shows_the_same_whoever_submits_and_whenever(
    isolation: IsolationLevel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = json.loads(_printed("python", VIEW, "a.py", isolation))
    # Another worker process: elsewhere, with other files open, other variables, later.
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SEAMARK_OTHER", "1")
    monkeypatch.setenv("TZ", "Asia/Tokyo")
    held = [os.dup(0) for _ in range(40)]
    before = os.umask(0o007)
    time.sleep(0.01)
    try:
        second = json.loads(_printed("python", VIEW, "b.py", isolation))
    finally:
        os.umask(before)
        for number in held:
            os.close(number)

    assert {name for name in first if first[name] != second[name]} <= DICE
    assert len(first) > 20


def _printed(language: str, source: bytes, name: str, isolation: IsolationLevel) -> str:
    ready = compiled(language, source, name, isolation=isolation)
    with Box(language, limits=Limits(), isolation=isolation) as box:
        box.load(ready, name, {"kp": 0.5}, LAYOUT)
        box.reset({"index": 0})
        box.step(VALUES)
        return box.finish().output.decode()
