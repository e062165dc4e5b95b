"""The scores of the trials of an entry: by the organiser's expression, or else the benchmark's."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim import registry
from seamark.sim.metrics.score_expression import score_of


def trial_scores(
    benchmark: str, config: Mapping[str, Any], trials: Sequence[Mapping[str, Any]]
) -> list[float]:
    """Return the score of each trial, not always a finite number.

    Parameters
    ----------
    trials
        As in the metrics of a run.

    Raises
    ------
    ExpressionInvalid
        If the expression has no value in a trial.
    """
    expression = registry.benchmark(benchmark).restore(config).custom_score()
    return [_score(expression, trial) for trial in trials]


def _score(expression: str, trial: Mapping[str, Any]) -> float:
    if not expression:
        return math.nan if trial["score"] is None else float(trial["score"])
    values = {"score": trial["score"]} | trial["overall"] | trial["measures"]
    return score_of(expression, values)
