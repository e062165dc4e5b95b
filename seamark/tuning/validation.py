"""The best candidate and the defaults with a seed that no candidate has had.

The best of many candidates is a lucky one with the seed of the search. Its score there is too high;
only another seed tells whether it is better.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from seamark.sim.engine.seeds import SEED_MAX
from seamark.sim.numerics.statistics import mean, paired_interval
from seamark.tuning.candidates import Evaluated, Evaluator


@dataclass(frozen=True, slots=True, kw_only=True)
class Validation:
    """Two configurations with the same fresh seed; None where a run failed or says nothing."""

    seed: int
    trials: int
    best: float | None  # scores
    defaults: float | None
    difference: float | None = None  # best minus defaults
    low: float | None = None  # of its 95 % interval, paired by trial
    high: float | None = None
    failure: str = ""

    @property
    def better(self) -> bool:
        """Whether the interval is above 0."""
        return self.low is not None and self.low > 0.0

    def sentence(self) -> str:
        """Return what the difference means."""
        if self.failure:
            return f"A run on fresh trials failed: {self.failure}"
        if self.low is None or self.high is None:
            return "Too few trials for an interval: give --validate more."
        if self.low > 0.0:
            return "The tuned configuration is better than the defaults on trials it has never met."
        if self.high < 0.0:
            return "The tuned configuration is worse than the defaults on trials it has never met."
        return "The difference may be luck: its interval contains 0."

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON values."""
        return asdict(self) | {"better": self.better, "sentence": self.sentence()}


def fresh_seed(seed: int) -> int:
    """Return a seed that no candidate has had: trials of another seed are independent."""
    return (seed + 1) % (SEED_MAX + 1)


def validate(
    evaluator: Evaluator,
    best: Mapping[str, Any],
    defaults: Mapping[str, Any],
    *,
    seed: int,
    trials: int,
    block: int,
) -> Validation:
    """Run two configurations with the same seed and compare them trial by trial.

    Parameters
    ----------
    block
        As in `seamark.sim.numerics.statistics.mean_interval`.
    """
    runs = [evaluator.repeat(config, seed=seed, trials=trials) for config in (best, defaults)]
    return compared(*runs, seed=seed, trials=trials, block=block)


def compared(
    best: Evaluated, defaults: Evaluated, *, seed: int, trials: int, block: int
) -> Validation:
    """Return the difference of two runs with the same seed and trials."""
    validation = Validation(seed=seed, trials=trials, best=best.score, defaults=defaults.score)
    if failure := best.failure or defaults.failure:
        return replace(validation, failure=failure)
    own, its = best.trial_scores, defaults.trial_scores
    low, high = paired_interval(own, its, block=block) or (None, None)
    return replace(validation, difference=mean(own) - mean(its), low=low, high=high)
