from dataclasses import dataclass, field
from typing import Any

import pytest

from seamark.server.runs.record.qualifier import qualifier
from seamark.server.runs.record.states import RunKind


@dataclass(frozen=True, kw_only=True)
class _Run:
    benchmark: str = "currents-v1"
    kind: RunKind = RunKind.PRACTICE
    config: dict[str, Any] = field(default_factory=dict)
    trials: int = 1
    score: float | None = 50.0
    rankable: bool | None = None


def test_a_ranked_run_needs_no_words_unless_the_rules_keep_it_off_the_leaderboard() -> None:
    assert qualifier(_Run(kind=RunKind.RANKED, rankable=True, trials=24)) == ""
    assert qualifier(_Run(kind=RunKind.RANKED, score=None, rankable=False)) == ""
    assert qualifier(_Run(kind=RunKind.RANKED, rankable=False)) == "not eligible for a rank"


@pytest.mark.parametrize(
    ("config", "trials", "words"),
    [
        ({}, 1, "practice, 1 trial"),
        ({"kp": 0.7}, 3, "practice, 3 trials"),  # the solution is the user's
        (
            {"levels": [0.0, 0.2], "level_duration_s": 60.0},
            1,
            "practice, changed scenario with 2 of 5 levels of 60 s, 1 trial",
        ),
        ({"levels": [0.35]}, 1, "practice, changed scenario with 1 other level, 1 trial"),
        ({"level_duration_s": 30.0}, 1, "practice, changed scenario with levels of 30 s, 1 trial"),
        ({"contact": False}, 1, "practice, changed scenario, 1 trial"),
        ({"tracker": "truth"}, 1, "practice, a solution that cannot rank, 1 trial"),
    ],
)
def test_a_practice_run_says_what_is_not_as_in_a_ranked_one(
    config: dict[str, Any], trials: int, words: str
) -> None:
    assert qualifier(_Run(config=config, trials=trials)) == words


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (_Run(benchmark="currents-v0", trials=2), "practice, 2 trials"),
        (_Run(kind=RunKind.LOG, config={"levels": [0.1]}), "log of a real mission"),
    ],
)
def test_earlier_benchmarks_and_logs_are_said_to_be_what_they_are(run: _Run, words: str) -> None:
    assert qualifier(run) == words
