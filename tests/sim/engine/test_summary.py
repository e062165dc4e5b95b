"""metrics.json: the score with its interval, and the two parts of a ranked run."""

import json
import math
from dataclasses import replace
from typing import Any

import pytest

from seamark.sim.benchmarks.benchmark import Benchmark, RankedProtocol
from seamark.sim.benchmarks.currents_v1.definition import CurrentsConfiguration
from seamark.sim.benchmarks.station_keeping.experiment import EXPERIMENT
from seamark.sim.engine.summary import custom_score, summarise
from seamark.sim.engine.trial import TrialResult
from seamark.sim.metrics import uwsim_metrics
from seamark.sim.numerics.statistics import mean
from seamark.sim.registry import benchmark
from seamark.sim.settings.configuration import Configuration
from tests.sim.conftest import SHORT, RunOf

PROTOCOL = benchmark("currents-v2").protocol or RankedProtocol(reference_trials=0, fresh_trials=0)
REFERENCE_TRIALS = PROTOCOL.reference_trials


def test_the_summary_is_json_with_trials_levels_and_an_interval(
    run_short: RunOf, short: Configuration
) -> None:
    result, _rows = run_short({})
    results = [result, replace(result, trial=1)]

    summary = summarise("currents-v1", short, results)

    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
    assert summary["score"] == pytest.approx(result.score)
    assert summary["score_low"] == pytest.approx(result.score)
    assert (summary["rankable"], summary["level_held"]) == (True, 0.3)
    assert [level["speed"] for level in summary["levels"]] == [0.1, 0.3]
    assert [trial["trial"] for trial in summary["trials"]] == [0, 1]


def test_one_trial_has_no_interval(run_short: RunOf, short: Configuration) -> None:
    result, _rows = run_short({})

    summary = summarise("currents-v1", short, [result])

    assert (summary["score_low"], summary["score_high"]) == (None, None)


@pytest.mark.parametrize("spoil", [{"points": math.nan}, {"whole_lost_percent": 100.0}])
def test_a_trial_without_a_finite_score_or_without_its_target_never_ranks(
    run_short: RunOf, short: CurrentsConfiguration, spoil: dict[str, float]
) -> None:
    result, _rows = run_short({})
    levels = (result.levels[0], {**result.levels[1], **spoil})
    spoiled = replace(result, levels=levels, trial_score=EXPERIMENT.trial_score(short, levels))

    summary = summarise("currents-v1", short, [result, spoiled])

    assert summary["rankable"] is False
    json.dumps(summary, allow_nan=False)


def test_the_custom_score_is_the_mean_of_the_trials(run_short: RunOf, currents: Benchmark) -> None:
    config = currents.read({**SHORT, "score": "time + 100 * collision - rmse_m"})
    result, _rows = run_short({})

    own = summarise("currents-v1", config, [result, result])["own_score"]

    assert own["expression"] == "time + 100 * collision - rmse_m"
    assert own["value"] == pytest.approx(12.0 + 100.0 - result.overall["rmse_m"])
    assert own["why"] == ""


def test_a_custom_score_without_a_value_says_why() -> None:
    own = custom_score("2 * settling_s", [{"settling_s": 1.0}, {"settling_s": None}])

    assert own is not None
    assert own["value"] is None
    assert "settling_s has no value" in own["why"]


def test_the_summary_has_the_original_metrics_of_every_level_and_of_the_run(
    run_short: RunOf, short: Configuration
) -> None:
    result, rows = run_short({})

    summary = summarise("currents-v1", short, [result])

    assert tuple(summary["measures"]) == uwsim_metrics.NAMES
    assert tuple(summary["levels"][0]["measures"]) == uwsim_metrics.NAMES
    assert summary["measures"]["distance"] == pytest.approx(uwsim_metrics.distance(rows))
    assert summary["overall"]["max_m"] == max(level["max_m"] for level in summary["levels"])


def test_a_ranked_run_is_scored_on_its_fresh_trials(run_short: RunOf, short: Configuration) -> None:
    results = _ranked(run_short, reference=90.0, fresh=60.0)

    summary = summarise("currents-v2", short, results, ranked=True)

    assert summary["score"] == pytest.approx(60.0)
    assert summary["score_low"] < 60.0 < summary["score_high"]
    assert summary["reference"]["score"] == pytest.approx(90.0)
    assert summary["reference"]["score_low"] < 90.0 < summary["reference"]["score_high"]
    parts = [trial["part"] for trial in summary["trials"]]
    assert parts == ["reference"] * REFERENCE_TRIALS + ["fresh"] * PROTOCOL.fresh_trials


def test_the_gap_is_how_much_higher_the_reference_score_is(
    run_short: RunOf, short: Configuration
) -> None:
    results = _ranked(run_short, reference=90.0, fresh=60.0)

    gap = summarise("currents-v2", short, results, ranked=True)["gap"]

    assert gap["value"] == pytest.approx(30.0)
    assert 28.0 < gap["low"] < 30.0 < gap["high"] < 32.0


def test_means_and_the_level_held_are_over_the_fresh_trials(
    run_short: RunOf, short: Configuration
) -> None:
    results = _ranked(run_short, reference=90.0, fresh=60.0)
    reference = [_with(result, level_held=0.1) for result in results[:REFERENCE_TRIALS]]

    mixed = [*reference, *results[REFERENCE_TRIALS:]]
    summary = summarise("currents-v2", short, mixed, ranked=True)

    assert summary["level_held"] == results[-1].trial_score.level_held == 0.3
    only_fresh = summarise("currents-v2", short, results[REFERENCE_TRIALS:])
    for name in ("overall", "measures", "levels", "own_score"):
        assert summary[name] == only_fresh[name]


def test_a_practice_run_has_no_parts(run_short: RunOf, short: Configuration) -> None:
    results = _ranked(run_short, reference=90.0, fresh=60.0)

    summary = summarise("currents-v2", short, results)

    assert not {"reference", "gap"} & set(summary)
    assert not any("part" in trial for trial in summary["trials"])
    assert summary["score"] == pytest.approx(mean([result.score for result in results]))


def test_a_ranked_run_of_a_first_version_has_no_parts(
    run_short: RunOf, short: Configuration
) -> None:
    result, _rows = run_short({})

    summary = summarise("currents-v1", short, [result], ranked=True)

    assert not {"reference", "gap"} & set(summary)


@pytest.mark.parametrize("more", [0, 1])
def test_a_run_ranks_while_at_most_a_quarter_of_its_fresh_trials_break_a_rule(
    run_short: RunOf, short: Configuration, more: int
) -> None:
    results = _ranked(run_short, reference=90.0, fresh=60.0)
    broken = PROTOCOL.fresh_trials // 4 + more
    for trial in range(PROTOCOL.trials - broken, PROTOCOL.trials):
        results[trial] = _with(results[trial], rankable=False, reason="It drove away.")

    summary = summarise("currents-v2", short, results, ranked=True)

    assert summary["rankable"] is (more == 0)
    first = PROTOCOL.trials - broken + 1
    assert summary["not_ranked"] == (
        f"Trial {first}: It drove away. So in {broken} of {PROTOCOL.fresh_trials} fresh trials; "
        f"{broken - 1} are excused."
        if more
        else None
    )


def test_a_fresh_trial_without_a_score_is_never_excused(
    run_short: RunOf, short: Configuration
) -> None:
    results = _ranked(run_short, reference=90.0, fresh=60.0)
    results[-1] = _with(results[-1], rankable=False, score=math.nan)

    summary = summarise("currents-v2", short, results, ranked=True)

    assert summary["rankable"] is False
    assert str(summary["not_ranked"]).startswith(
        f"Trial {PROTOCOL.trials}: The trial has no finite"
    )


def test_a_reference_trial_decides_nothing_about_the_rank(
    run_short: RunOf, short: Configuration
) -> None:
    results = _ranked(run_short, reference=90.0, fresh=60.0)
    results[0] = _with(results[0], rankable=False, reason="It drove away.")

    summary = summarise("currents-v2", short, results, ranked=True)

    assert (summary["rankable"], summary["not_ranked"]) == (True, None)


@pytest.mark.parametrize(
    ("qualities", "midpoint"), [((0.9, 0.1), pytest.approx(0.3, abs=0.05)), ((0.02, 0.0), None)]
)
def test_there_is_no_midpoint_outside_the_levels(
    run_short: RunOf, short: Configuration, qualities: tuple[float, float], midpoint: Any
) -> None:
    results = _ranked(run_short, reference=90.0, fresh=60.0)
    first = results[0].levels[0]
    levels = tuple(
        first | {"level": at, "speed": 0.1 + 0.4 * at, "quality": quality}
        for at, quality in enumerate(qualities)
    )
    results = [replace(result, levels=levels) for result in results]

    summary = summarise("currents-v2", short, results, ranked=True)

    assert summary["overall"]["current_midpoint_m_s"] == midpoint


def _ranked(run_short: RunOf, *, reference: float, fresh: float) -> list[TrialResult]:
    """Return the trials of a ranked run, with scores that alternate by 1 around two means."""
    result, _rows = run_short({})
    # The levels of currents-v2 have a quality, to which the midpoint is fitted.
    levels = tuple(dict(level, quality=0.5) for level in result.levels)
    result = replace(result, levels=levels)
    means = [reference] * REFERENCE_TRIALS + [fresh] * PROTOCOL.fresh_trials
    scores = [mean + (-1) ** (trial // PROTOCOL.block) for trial, mean in enumerate(means)]
    return [_with(replace(result, trial=trial), score=score) for trial, score in enumerate(scores)]


def _with(result: TrialResult, **changes: Any) -> TrialResult:
    return replace(result, trial_score=replace(result.trial_score, **changes))
