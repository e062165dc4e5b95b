"""The scores of an entry and of its trials: by the organiser's expression, or the benchmark's."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from seamark.sim import registry
from seamark.sim.metrics.score_expression import score_of
from seamark.sim.numerics.statistics import block_means, mean, mean_interval, standard_error


@dataclass(frozen=True, slots=True, kw_only=True)
class EntryScore:
    """The score of an entry by the rules of its competition, or why it has none."""

    refusal: str | None = None
    scores: tuple[float, ...] = ()  # of the trials
    score: float | None = None
    low: float | None = None
    high: float | None = None
    standard_error: float | None = None
    degrees: int = 0


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


def summary(scores: Sequence[float], block: int) -> EntryScore:
    """Return the mean of the scores of trials with its 95 % interval.

    Parameters
    ----------
    block
        Number of consecutive trials whose mean is one observation: `RankedProtocol.block`.
    """
    means = block_means(scores, block)
    error = standard_error(means)
    known = math.isfinite(error)
    low, high = mean_interval(scores, block=block) or (None, None)
    return EntryScore(
        scores=tuple(scores),
        score=mean(scores),
        low=low,
        high=high,
        standard_error=error if known else None,
        degrees=len(means) - 1 if known else 0,
    )
