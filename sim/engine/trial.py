"""A trial is one seed through all levels; a run is one or more trials and their summary."""

import math
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np

from seamark.sim import registry
from seamark.sim.engine.experiment import TrialScore
from seamark.sim.metrics import uwsim_metrics
from seamark.sim.metrics.metric import mean_over_trials, over_run
from seamark.sim.metrics.score_expression import ExpressionInvalid, score_of
from seamark.sim.numerics.statistics import mean, mean_interval
from seamark.sim.recording.telemetry import Digest, OnRows, Rows
from seamark.sim.settings.configuration import Configuration


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialResult:
    """The result of a trial. It has no seed on purpose: that may be a hidden one."""

    trial: int
    levels: tuple[Mapping[str, Any], ...]  # the metrics of each level
    trial_score: TrialScore
    digest: str  # SHA-256 of this trial's telemetry
    rows: int

    @property
    def overall(self) -> dict[str, Any]:
        """Return the metrics over all levels."""
        return _plain(self.trial_score.overall)

    @property
    def measures(self) -> dict[str, Any]:
        """Return the original benchmark module's metrics over all levels."""
        return _plain(over_run(uwsim_metrics.METRICS, [level["measures"] for level in self.levels]))

    @property
    def score(self) -> float:
        """Return the trial's score in the unit of the benchmark's headline."""
        return self.trial_score.score


def run_trial(
    benchmark: str,
    config: Configuration,
    solution: Any,
    *,
    seed: int,
    trial: int,
    on_rows: OnRows,
) -> TrialResult:
    """Run all levels and return the metrics.

    Rows go to `on_rows` in order, every 20 control steps and at the end; also when the solution
    raises, so that no row is lost.

    Parameters
    ----------
    solution
        What the benchmark evaluates: a `Program` or a `Tracker`.

    Raises
    ------
    KeyError
        If there is no such benchmark.
    TypeError
        If the configuration belongs to another benchmark.
    Exception
        Whatever the solution raises, unchanged.
    """
    entry = registry.benchmark(benchmark)
    if not isinstance(config, entry.configuration):
        raise TypeError(f"{benchmark} cannot run a {type(config).__name__}")
    config, experiment = config.for_trial(trial), entry.load()
    digest = Digest()
    kept: list[Rows] = []

    def deliver(rows: Rows) -> None:
        digest.add(rows)
        kept.append(rows)
        on_rows(rows)

    levels: list[dict[str, Any]] = []
    rows = 0
    for level in range(len(config.level_values())):
        running = experiment.level(config, solution, seed=seed, trial=trial, level=level)
        with closing(running):
            running.run(deliver)
        whole = np.concatenate(kept)
        original = uwsim_metrics.level_metrics(whole)
        levels.append(experiment.metrics(config, level, whole) | {"measures": original})
        rows += len(whole)
        kept.clear()
    return TrialResult(
        trial=trial,
        levels=tuple(levels),
        trial_score=experiment.trial_score(config, levels),
        digest=digest.hexdigest(),
        rows=rows,
    )


def summarise(
    benchmark: str, config: Configuration, results: Sequence[TrialResult]
) -> dict[str, Any]:
    """Return metrics.json: the score with its interval, every trial, the means over the trials.

    `overall` and `measures` are over all levels, `levels` holds each level.
    `score_low` and `score_high` are the 95 % interval of the mean (`mean_interval`), or None.
    `rankable` is false if a trial has no finite score or lost its target for a whole level.
    """
    scores = [result.score for result in results]
    interval = mean_interval(scores) if all(map(math.isfinite, scores)) else None
    rankable = bool(results) and all(result.trial_score.rankable for result in results)
    held = [result.trial_score.level_held for result in results]
    return {
        "benchmark": benchmark,
        "score": mean(scores) if scores and all(map(math.isfinite, scores)) else None,
        "score_low": interval[0] if interval else None,
        "score_high": interval[1] if interval else None,
        "rankable": rankable,
        "level_held": _lowest(held),
        "overall": _mean_overall([result.overall for result in results]),
        "own_score": custom_score(
            config.custom_score(), [_expression_values(result) for result in results]
        ),
        "measures": _mean_overall([result.measures for result in results]),
        "trials": [_entry(result) for result in results],
        "levels": [
            mean_over_trials([_plain(level) for level in same])
            for same in zip(*(result.levels for result in results), strict=True)
        ],
    }


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


def _plain(level: Mapping[str, Any]) -> dict[str, Any]:
    """Return metrics for JSON: None for nan and infinity."""
    return {
        name: _plain(value)
        if isinstance(value, Mapping)
        else None
        if isinstance(value, float) and not math.isfinite(value)
        else value
        for name, value in level.items()
    }


def _entry(result: TrialResult) -> dict[str, Any]:
    return {
        "trial": result.trial,
        "score": result.score if math.isfinite(result.score) else None,
        "level_held": result.trial_score.level_held,
        "overall": result.overall,
        "rankable": result.trial_score.rankable,
        "digest": result.digest,
        "measures": result.measures,
        "levels": [_plain(level) for level in result.levels],
    }
