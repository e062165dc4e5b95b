"""Hostile trackers: wrong answers, forged ones, late ones, and attacks on the images' memory."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from sandbox.box import Box
from sandbox.level import Level
from sandbox.limits import Limits
from sandbox.outcome import Outcome, ProgramEnded

pytestmark = pytest.mark.host

TRACKERS = Path(__file__).with_name("trackers")
TABLE = tomllib.loads(TRACKERS.with_suffix(".toml").read_text(encoding="utf-8"))
CORNERS = [[10.0, 20.0], [30.0, 20.0], [30.0, 40.0], [10.0, 40.0]]
SHOWN = 6
LIMITS = Limits(
    cpu_s=1.0, wall_s=20.0, start_wall_s=5.0, step_wall_s=0.7, memory_mib=128, processes=16
)


def shown(name: str, level: Level) -> tuple[Outcome, list[object]]:
    """Show a tracker some images; return how it ended and what it answered."""
    answers: list[object] = []
    image = np.zeros((240, 320), np.uint8)
    with Box(limits=LIMITS, level=level) as box:
        try:
            box.load((TRACKERS / f"{name}.py").read_bytes(), "mine.py", {}, {"role": "tracker"})
            box.start(image, CORNERS)
            for value in range(SHOWN):
                image[:] = value
                answers.append(box.update(image))
            return box.finish(), answers
        except ProgramEnded as end:
            return end.outcome, answers


def test_every_tracker_has_an_expectation_and_every_expectation_a_tracker() -> None:
    assert {path.stem for path in TRACKERS.glob("*.py")} == set(TABLE)


@pytest.mark.parametrize("name", sorted(TABLE))
def test_a_hostile_tracker_ends_as_the_table_says(name, level) -> None:
    expected = TABLE[name]

    outcome, answers = shown(name, level)

    assert b"GOT" not in outcome.output
    assert outcome.verdict == expected["verdict"], outcome
    assert re.search(expected.get("says", ""), outcome.sentence), outcome.sentence
    assert np.isfinite(np.array([answer for answer in answers if answer])).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["keeps_every_image", "sleeps", "spins", "unprotects_image"])
def test_it_gets_nothing_at_level_medium_either(name, level) -> None:
    outcome, _ = shown(name, Level.MEDIUM)

    assert b"GOT" not in outcome.output
    assert outcome.verdict == TABLE[name]["verdict"], outcome
