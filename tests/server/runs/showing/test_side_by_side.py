"""What runs side by side have in common, and in what they differ."""

from functools import partial
from typing import Any

import pytest

from seamark.server.runs.record.seeds import trial_seeds
from seamark.server.runs.showing.side_by_side import SideBySide, side_by_side
from tests.cast import Backend

SHORT = {"levels": [0.1, 0.3], "level_duration_s": 4.0, "settle_s": 1.0}
TRIALS = (40.0, 60.0, 53.0)


def _finished(backend: Backend, score: float, who: str = "ann", **changes: Any) -> int:
    """Return a practice run of three trials, whose scores are `score` more than in TRIALS."""
    changes = {"seed": 7, "trials": 3, "config": SHORT} | changes
    claim = backend.running(who, **changes)
    trials = [{"trial": at, "score": luck + score} for at, luck in enumerate(TRIALS)]
    metrics = {"score": 51.0 + score, "trials": trials, "overall": {"rmse_m": 1.0 / score}}
    metrics["levels"] = [{"level": at, "rmse_m": 0.1 * at + score} for at in range(2)]
    assert backend.finish(claim, metrics=metrics)
    return claim.run_id


def _compared(backend: Backend, *ids: int) -> SideBySide:
    seeds_of = partial(trial_seeds, settings=backend.settings)
    return side_by_side([backend.show(run_id) for run_id in ids], seeds_of)


def test_only_the_settings_that_differ_are_listed(backend: Backend) -> None:
    first = _finished(backend, 1.0, config=SHORT | {"kp": 0.4})
    second = _finished(backend, 2.0, config=SHORT | {"kp": 0.6}, seed=8)

    found = _compared(backend, first, second)

    rows = {row.name: row.values for row in found.settings}
    assert rows == {"kp": ("0.4", "0.6"), "seed": ("7", "8")}


def test_a_setting_without_effect_has_no_value(backend: Backend) -> None:
    pi = _finished(backend, 1.0, config=SHORT | {"ki": 0.05})
    p = _finished(backend, 2.0, controller="p", config=SHORT | {"ki": 0.05})

    rows = {row.name: row.values for row in _compared(backend, pi, p).settings}

    assert rows["ki"] == ("0.05", None)
    assert "solution" in rows


def test_scores_of_the_same_seed_are_compared_trial_by_trial(backend: Backend) -> None:
    first, second = _finished(backend, 1.0), _finished(backend, 3.5)

    (difference,) = _compared(backend, first, second).scores

    assert (difference.run, difference.other) == (second, first)
    assert difference.paired_trials == 3
    assert difference.difference == pytest.approx(2.5)
    assert difference.low == pytest.approx(difference.high) == pytest.approx(2.5)
    assert "same conditions" in difference.sentence


def test_scores_of_other_seeds_are_independent(backend: Backend) -> None:
    first, second = _finished(backend, 1.0), _finished(backend, 3.5, seed=8)

    (difference,) = _compared(backend, first, second).scores

    assert difference.paired_trials == 0
    assert difference.difference == pytest.approx(2.5)
    assert difference.low is not None
    assert difference.high is not None
    assert difference.low < -10.0 < 10.0 < difference.high


def test_another_scenario_is_other_water_and_no_metric_is_marked(backend: Backend) -> None:
    first = _finished(backend, 1.0)
    second = _finished(backend, 3.5, config=SHORT | {"altitude_m": 2.5})

    found = _compared(backend, first, second)

    assert found.scores[0].paired_trials == 0
    assert "Camera altitude" in found.scores[0].sentence
    assert "Camera altitude" in found.note
    assert {row.best for row in found.metrics} == {()}


def test_the_best_values_are_marked(backend: Backend) -> None:
    ids = [_finished(backend, score) for score in (1.0, 3.0, 3.0)]

    rows = {(row.label, row.level): row for row in _compared(backend, *ids).metrics}

    assert rows["Score", ""].best == (1, 2)
    (over_levels,) = [row for (_, level), row in rows.items() if not level and row.unit == "m"]
    assert over_levels.best == (1, 2)
    (at_a_level,) = [row for (_, level), row in rows.items() if level == "0.3 m/s"]
    assert at_a_level.best == (0,)


def test_reference_trials_of_ranked_runs_are_in_the_same_water(backend: Backend) -> None:
    ids = []
    for score in (0.3, 0.4):
        claim = backend.running("ann", kind="ranked", benchmark="currents-v2", config={"kp": score})
        trials = [{"score": score + 0.1 * at, "part": "reference"} for at in range(8)]
        trials += [{"score": 0.1, "part": "fresh"}] * 24
        assert backend.finish(claim, metrics={"score": 0.1, "trials": trials})
        ids.append(claim.run_id)

    (difference,) = _compared(backend, *ids).scores

    assert difference.paired_trials == 8
    assert difference.difference == pytest.approx(0.1)
    assert difference.low == pytest.approx(0.1)


def test_a_practice_run_on_the_public_seed_is_paired_with_the_reference_trials(
    backend: Backend,
) -> None:
    claim = backend.running("ann", kind="ranked", benchmark="currents-v2")
    trials = [{"score": 0.1 * at, "part": "reference"} for at in range(8)]
    trials += [{"score": 0.1, "part": "fresh"}] * 24
    assert backend.finish(claim, metrics={"score": 0.1, "trials": trials})
    practice = _finished(backend, 1.0, benchmark="currents-v2", seed=2026, trials=3, config={})

    (difference,) = _compared(backend, claim.run_id, practice).scores

    assert difference.paired_trials == 3


def test_runs_of_different_benchmarks_are_compared_but_for_scores_and_metrics(
    backend: Backend,
) -> None:
    first = _finished(backend, 1.0)
    second = _finished(backend, 3.5, benchmark="currents-v2", config={})

    found = _compared(backend, first, second)

    assert found.metrics == ()
    assert found.scores[0].difference is None
    assert "currents-v1 and currents-v2" in found.note


def test_a_run_without_a_score_says_so(backend: Backend) -> None:
    first, failed = _finished(backend, 1.0), backend.failed({"title": "It failed"})

    found = _compared(backend, first, failed)

    assert found.scores[0].difference is None
    assert f"Run {failed} has no score: it is failed." in found.scores[0].sentence
