"""Hostile trackers: wrong answers, forged ones, late ones, and attacks on the images' memory.

In Python, C, C++ and MATLAB.
"""

import re
import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import language_of
from seamark.sandbox.outcome import Outcome, ProgramEnded
from seamark.sandbox.probing.self_test import tried
from seamark.sandbox.protocol.answers import Loss
from tests.hostile.conftest import limits_for

pytestmark = pytest.mark.host

TRACKERS = Path(__file__).with_name("trackers")
TABLE = tomllib.loads(TRACKERS.with_suffix(".toml").read_text(encoding="utf-8"))
CORNERS = [[10.0, 20.0], [30.0, 20.0], [30.0, 40.0], [10.0, 40.0]]
SHOWN = 6
MEMORY_MIB = {"matlab": 256}  # it has 180 MiB of address space by itself
MEDIUM = ["keeps_every_image.py", "sleeps.py", "spins.py", "unprotects_image.py"]
MEDIUM += ["resizes_images.c", "unprotects_image.c", "writes_image.c", "changes_image.m"]


@cache
def missing(language: str, isolation: IsolationLevel) -> str:
    return tried(language, isolation).why_not


def shown(name: str, isolation: IsolationLevel) -> tuple[Outcome, list[object]]:
    """Show a tracker some images; return how it ended and what it answered."""
    answers: list[object] = []
    image = np.zeros((240, 320), np.uint8)
    language = language_of(name) or ""
    if why := missing(language, isolation):
        pytest.skip(why)
    limits = replace(limits_for(TABLE[name]), memory_mib=MEMORY_MIB.get(language, 128))
    with Box(language, limits=limits, isolation=isolation) as box:
        try:
            source = compiled(language, (TRACKERS / name).read_bytes(), name, isolation=isolation)
            box.load(source, name, {}, {"role": "tracker"})
            box.start(image, CORNERS)
            for value in range(SHOWN):
                image[:] = value
                answers.append(box.update(image))
            return box.finish(), answers
        except ProgramEnded as end:
            return end.outcome, answers


def test_every_tracker_has_an_expectation_and_every_expectation_a_tracker() -> None:
    assert {path.name for path in TRACKERS.iterdir() if path.is_file()} == set(TABLE)


@pytest.mark.parametrize("name", sorted(TABLE))
def test_a_hostile_tracker_ends_as_the_table_says(name, isolation) -> None:
    expected = TABLE[name]

    # Without control groups nothing counts for the whole box: see test_languages.py.
    named = expected.get("medium") if isolation is IsolationLevel.MEDIUM else None

    outcome, answers = shown(name, isolation)

    assert b"GOT" not in outcome.output
    assert outcome.verdict == (named or expected["verdict"]), outcome
    assert re.search(expected.get("says", ""), outcome.sentence), outcome.sentence
    assert not re.search(r"/tmp/|/box/|\x1b", outcome.sentence + outcome.traceback)
    corners = [answer for answer in answers if not isinstance(answer, Loss)]
    assert np.isfinite(np.array(corners)).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", MEDIUM)
def test_it_achieves_nothing_with_medium_isolation_either(name, isolation) -> None:
    outcome, _ = shown(name, IsolationLevel.MEDIUM)

    assert b"GOT" not in outcome.output
    assert outcome.verdict == TABLE[name]["verdict"], outcome
