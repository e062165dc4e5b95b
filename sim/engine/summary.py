"""metrics.json: the summary of the trials of a run, and the two parts of a ranked one."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim import registry
from seamark.sim.engine.seeds import FRESH, REFERENCE
from seamark.sim.engine.trial import TrialResult, plain
from seamark.sim.metrics.metric import mean_over_trials
from seamark.sim.metrics.score_expression import ExpressionInvalid, score_of
from seamark.sim.numerics.psychometric import psychometric_midpoint
from seamark.sim.numerics.statistics import difference_interval, mean, mean_interval
from seamark.sim.settings.configuration import Configuration

NO_SCORE = "The trial has no finite score."
_Trials = Sequence[TrialResult]


def summarise(
    benchmark: str, config: Configuration, results: _Trials, *, ranked: bool = False
) -> dict[str, Any]:
    """Return metrics.json: the score with its interval, every trial, the means over the trials.

    `overall` and `measures` are over all levels, `levels` holds each level.
    `score_low` and `score_high` are the 95 % interval of the mean; None for one trial.
    `rankable` is false if a trial breaks a rule of the benchmark, or in a ranked run with fresh
    trials more of them than the protocol excuses; `not_ranked` then has the reason.

    In a ranked run of a benchmark with a `RankedProtocol`, all of these are over the fresh trials.
    `reference` has the score of the reference trials, `gap` how much higher it is than that of the
    fresh ones (the generalisation gap), and each of the `trials` says which `part` it belongs to.
    """
    protocol = registry.benchmark(benchmark).protocol
    block = 1 if protocol is None else protocol.block
    if protocol is None or not ranked:
        return _means(benchmark, config, results, block) | {"trials": list(map(_entry, results))}
    reference = results[: protocol.reference_trials]
    fresh = results[protocol.reference_trials :]
    entries = [_entry(result) | {"part": REFERENCE} for result in reference]
    entries += [_entry(result) | {"part": FRESH} for result in fresh]
    known = _score(reference, block)
    means = _means(benchmark, config, fresh, block, excused=protocol.excused_trials)
    return means | {"trials": entries, "reference": known, "gap": _gap(reference, fresh, block)}


def _means(
    benchmark: str, config: Configuration, results: _Trials, block: int, *, excused: int = 0
) -> dict[str, Any]:
    """Return the score and all that is a mean over some trials."""
    refusal = _refusal(results, excused)
    levels = [
        mean_over_trials([plain(level) for level in same])
        for same in zip(*(result.levels for result in results), strict=True)
    ]
    overall = _mean_overall([result.overall for result in results])
    return {
        "benchmark": benchmark,
        **_score(results, block),
        "rankable": bool(results) and refusal is None,
        "not_ranked": refusal,
        "level_held": _lowest([result.trial_score.level_held for result in results]),
        "overall": overall | _midpoint(benchmark, levels, len(results)),
        "own_score": custom_score(
            config.custom_score(), [_expression_values(result) for result in results]
        ),
        "measures": _mean_overall([result.measures for result in results]),
        "levels": levels,
    }


def _score(results: _Trials, block: int) -> dict[str, float | None]:
    """Return the mean score of some trials with its interval; None where there is none."""
    scores = _finite_scores(results)
    low, high = mean_interval(scores, block=block) or (None, None)
    return {"score": mean(scores) if scores else None, "score_low": low, "score_high": high}


def _gap(reference: _Trials, fresh: _Trials, block: int) -> dict[str, float | None]:
    """Return how much higher the score of the reference trials is, with its interval."""
    known, drawn = _finite_scores(reference), _finite_scores(fresh)
    if not known or not drawn:
        return {"value": None, "low": None, "high": None}
    low, high = difference_interval(known, drawn, block=block) or (None, None)
    return {"value": mean(known) - mean(drawn), "low": low, "high": high}


def _midpoint(
    benchmark: str, levels: Sequence[Mapping[str, Any]], trials: int
) -> dict[str, float | None]:
    """Return the fitted midpoint, if the benchmark has one, from the means of the levels.

    It is None outside the levels, where nothing was measured.
    """
    declared = registry.benchmark(benchmark).midpoint
    if declared is None:
        return {}
    points = [point for level in levels if (point := declared.point(level)) is not None]
    values, shares = [value for value, _ in points], [share for _, share in points]
    fit = psychometric_midpoint(
        values, [trials * share for share in shares], [trials] * len(shares)
    )
    inside = fit is not None and min(values) <= fit.midpoint <= max(values)
    return {declared.metric.name: fit.midpoint if fit is not None and inside else None}


def _finite_scores(results: _Trials) -> list[float]:
    """Return the scores; none at all if one of them is not finite."""
    scores = [result.score for result in results]
    return scores if all(map(math.isfinite, scores)) else []


def _refusal(results: _Trials, excused: int) -> str | None:
    """Return why the run does not rank, if a trial has no score or too many break a rule."""
    broken = [result for result in results if not result.trial_score.rankable]
    if len(broken) <= excused and all(math.isfinite(result.score) for result in broken):
        return None
    first = broken[0]
    reason = f"Trial {first.trial + 1}: {first.trial_score.reason or NO_SCORE}"
    if not excused:
        return reason
    return f"{reason} So in {len(broken)} of {len(results)} fresh trials; {excused} are excused."


def _mean_overall(trials: Sequence[Mapping[str, float | None]]) -> dict[str, float | None]:
    """Return the mean of each metric over the trials that have it; None if none has."""
    result: dict[str, float | None] = {}
    for name in trials[0] if trials else ():
        known = [value for trial in trials if (value := trial[name]) is not None]
        result[name] = mean(known) if known else None
    return result


def _expression_values(result: TrialResult) -> dict[str, Any]:
    """Return the values of a trial that an expression may use."""
    return {"score": result.score} | result.overall | result.measures


def custom_score(
    expression: str, trials: Sequence[Mapping[str, float | None]]
) -> dict[str, Any] | None:
    """Return the value of the user's expression, mean over the trials; None without one.

    `value` is None if it has none; `why` then has the reason.
    """
    if not expression:
        return None
    try:
        values = [score_of(expression, trial) for trial in trials]
    except ExpressionInvalid as error:
        return {"expression": expression, "value": None, "why": str(error)}
    return {"expression": expression, "value": mean(values), "why": ""}


def _lowest(held: Sequence[float | None]) -> float | None:
    known = [speed for speed in held if speed is not None]
    return min(known) if known and len(known) == len(held) else None


def _entry(result: TrialResult) -> dict[str, Any]:
    drawn = {"conditions": dict(result.conditions)} if result.conditions else {}
    return drawn | {
        "trial": result.trial,
        "score": result.score if math.isfinite(result.score) else None,
        "level_held": result.trial_score.level_held,
        "overall": result.overall,
        "rankable": result.trial_score.rankable,
        "digest": result.digest,
        "measures": result.measures,
        "levels": [plain(level) for level in result.levels],
    }
