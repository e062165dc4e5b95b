"""What the owner of a program in Python reads about a mistake."""

import contextlib

import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict
from tests.sandbox.conftest import LAYOUT, VALUES

pytestmark = pytest.mark.host
QUICK = Limits(step_cpu_s=0.3, step_wall_s=1.0)
CONTROLLER = """\
class Controller:
    def __init__(self, config):
        self.gain = config[{key!r}]

    def step(self, observation):
        {step}

    def search(self):
        while True:
            pass
"""


def _ended(isolation: IsolationLevel, *, key: str = "kp", step: str) -> Outcome:
    source = CONTROLLER.format(key=key, step=step).encode()
    with Box(limits=QUICK, isolation=isolation) as box:
        with contextlib.suppress(ProgramEnded):
            box.load(source, "mine.py", {"kp": 0.5, "ki": 0.02}, LAYOUT)
            box.step(VALUES)
        assert box.outcome is not None
        return box.outcome


def test_an_endless_loop_names_its_line_and_shows_how_it_came_there(
    isolation: IsolationLevel,
) -> None:
    outcome = _ended(isolation, step="self.search()")

    assert outcome.verdict is Verdict.TIME_LIMIT
    assert "did not return" in outcome.sentence
    assert outcome.sentence.rpartition(" It was in ")[2] in (
        "line 9 of mine.py.",
        "line 10 of mine.py.",
    )
    assert 'File "mine.py", line 6, in step' in outcome.traceback
    assert "runner.py" not in outcome.traceback


def test_a_program_that_sleeps_names_its_line(isolation: IsolationLevel) -> None:
    outcome = _ended(isolation, step="import time; time.sleep(60)")

    assert outcome.verdict is Verdict.TIME_LIMIT
    assert outcome.sentence.endswith("It was in line 6 of mine.py.")


def test_a_program_that_ignores_the_question_ends_at_its_limit_all_the_same(
    isolation: IsolationLevel,
) -> None:
    ignored = "import signal; signal.signal(signal.SIGUSR1, signal.SIG_IGN); self.search()"
    outcome = _ended(isolation, step=ignored)

    assert outcome.verdict is Verdict.TIME_LIMIT
    assert "It was in" not in outcome.sentence


def test_a_missing_setting_names_those_that_exist(isolation: IsolationLevel) -> None:
    outcome = _ended(isolation, key="Kp", step="return [0, 0, 0, 0]")

    assert outcome.verdict is Verdict.USER_ERROR
    assert outcome.sentence.startswith("KeyError: config has no key 'Kp'; it has ki, kp")


def test_a_missing_measurement_names_those_that_exist(isolation: IsolationLevel) -> None:
    outcome = _ended(isolation, step="return [observation['speed'], 0, 0, 0]")

    assert outcome.sentence.startswith("KeyError: the observation has no key 'speed'; it has ")
    assert "error" in outcome.sentence


def test_a_value_that_is_no_number_is_named_by_what_it_commands(isolation: IsolationLevel) -> None:
    outcome = _ended(isolation, step="return [0, float('nan'), 0, 0]")

    assert outcome.verdict is Verdict.PROTOCOL_ERROR
    assert outcome.sentence.startswith("step returned nan for the sway; step must return four")
