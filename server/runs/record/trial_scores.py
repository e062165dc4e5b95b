"""The scores of the single trials of a run, as its metrics.json has them."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim import registry
from seamark.sim.engine.seeds import FRESH
from seamark.sim.numerics.statistics import block_means, standard_error


def trial_scores(metrics: Mapping[str, Any] | None, part: str) -> list[float]:
    """Return the scores of a part in the order of the trials; none if one has no score.

    The trials of a benchmark without a protocol, and those of practice runs, count as fresh.
    """
    trials: Sequence[Mapping[str, Any]] = (metrics or {}).get("trials", ())
    scores = [trial["score"] for trial in trials if trial.get("part", FRESH) == part]
    return [] if None in scores else scores


def block_of(benchmark: str) -> int:
    """Return how many consecutive trials of a benchmark are one observation; 1 if it is gone."""
    protocol = registry.benchmark(benchmark).protocol if benchmark in registry.BENCHMARKS else None
    return 1 if protocol is None else protocol.block


def error_of_score(benchmark: str, metrics: Mapping[str, Any] | None) -> tuple[float | None, int]:
    """Return the standard error of a run's score and its degrees of freedom; None if unknown."""
    means = block_means(trial_scores(metrics, FRESH), block_of(benchmark))
    error = standard_error(means)
    return (error, len(means) - 1) if math.isfinite(error) else (None, 0)
