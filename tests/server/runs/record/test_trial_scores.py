"""What the leaderboard takes from the trials of a run."""

import pytest

from seamark.server.runs.record.trial_scores import error_of_score, trial_scores
from seamark.sim.engine.seeds import FRESH, REFERENCE
from seamark.sim.numerics.statistics import mean_interval
from seamark.sim.numerics.student_t import quantile

FRESH_SCORES = [0.31, 0.12, 0.35, 0.11, 0.29, 0.16, 0.33, 0.09]  # vehicles in turn


def _metrics(*, parts: bool = True) -> dict[str, object]:
    reference = [{"score": score} for score in (0.9, 0.5)]
    fresh = [{"score": score} for score in FRESH_SCORES]
    if not parts:
        return {"trials": fresh}
    trials = [each | {"part": REFERENCE} for each in reference]
    return {"trials": trials + [each | {"part": FRESH} for each in fresh]}


@pytest.mark.parametrize(("benchmark", "block"), [("currents-v2", 2), ("visibility-v2", 1)])
def test_the_error_is_that_of_the_interval_beside_the_score(benchmark: str, block: int) -> None:
    error, degrees = error_of_score(benchmark, _metrics())

    interval = mean_interval(FRESH_SCORES, block=block)
    assert error is not None
    assert interval is not None
    assert 2.0 * quantile(0.025, degrees) * error == pytest.approx(interval[1] - interval[0])


def test_all_trials_of_a_benchmark_without_fresh_ones_count() -> None:
    assert trial_scores(_metrics(parts=False), FRESH) == FRESH_SCORES
    assert trial_scores(_metrics(parts=False), REFERENCE) == []


@pytest.mark.parametrize(
    "metrics",
    [None, {}, {"trials": []}, {"trials": [{"score": 1.0}]}, {"trials": [{"score": None}] * 3}],
)
def test_without_several_scores_the_error_is_unknown(metrics: dict[str, object] | None) -> None:
    assert error_of_score("visibility-v2", metrics) == (None, 0)


def test_a_benchmark_that_is_gone_has_single_trials() -> None:
    error, degrees = error_of_score("currents-v0", _metrics(parts=False))

    assert error is not None
    assert degrees == len(FRESH_SCORES) - 1
