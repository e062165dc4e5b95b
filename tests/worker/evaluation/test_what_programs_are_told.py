"""A program that looks for the strength of the current in all that it is told."""

import pytest

from seamark.worker.evaluation.local import evaluate_locally
from seamark.worker.ipc.outcomes import RunOutcome

pytestmark = pytest.mark.host

SHORT = {"levels": [0.1, 0.3], "level_duration_s": 2.0, "settle_s": 1.0, "tracker": "truth"}
BY_INDEX = b"""
class Controller:
    def __init__(self, config):
        self.config = config

    def reset(self, level):
        self.speed = self.config["levels"][level["index"]]

    def step(self, observation):
        return [0.0, 0.0, 0.0, 0.0]
"""
# Raises if a number that the run was given as the speed of a level is anywhere.
BY_VALUE = b"""
SPEEDS = {0.1237, 0.3219}


def numbers(value):
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, (list, tuple)):
        return {number for item in value for number in numbers(item)}
    return {value} if isinstance(value, (int, float)) else set()


class Controller:
    def __init__(self, config):
        self.found = numbers(config) & SPEEDS

    def reset(self, level):
        assert not (self.found | numbers(level) & SPEEDS), "found"

    def step(self, observation):
        fields = [numbers(float(x)) for name in observation for x in [observation[name]] if not
                  hasattr(x, "shape")]
        assert not set().union(*fields) & SPEEDS, "found"
        return [0.0, 0.0, 0.0, 0.0]
"""


def outcome_of(benchmark: str, program: bytes, isolation, **settings: object) -> RunOutcome:
    return evaluate_locally(
        benchmark,
        SHORT | settings,
        seed=5,
        controller=(program, "controller.py"),
        isolation=isolation,
    )


@pytest.mark.parametrize(
    ("benchmark", "failure"), [("currents-v1", None), ("currents-v2", "user_error")]
)
def test_the_index_of_a_level_tells_the_current_in_the_first_version_alone(
    benchmark: str, failure: str | None, isolation
) -> None:
    outcome = outcome_of(benchmark, BY_INDEX, isolation)

    assert outcome.failure == failure
    assert ("KeyError" in outcome.sentence) is (failure is not None)


@pytest.mark.parametrize(
    ("benchmark", "failure"), [("currents-v1", "user_error"), ("currents-v2", None)]
)
def test_the_speed_of_a_level_is_nowhere_in_what_a_program_of_the_second_version_is_told(
    benchmark: str, failure: str | None, isolation
) -> None:
    outcome = outcome_of(benchmark, BY_VALUE, isolation, levels=[0.1237, 0.3219])

    assert outcome.failure == failure
    assert ("found" in outcome.sentence) is (failure is not None)
