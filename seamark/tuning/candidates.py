"""Candidates: the configurations that are tried, and what came of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from seamark.tuning.search_space import Value

DEFAULTS = 0  # number of the candidate with the values that hold without tuning


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A configuration to try; `values` are those of the tuned parameters."""

    number: int
    values: Mapping[str, Value]


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluated:
    """How the run of a candidate ended: with a score, or with a sentence why there is none."""

    score: float | None = None  # mean over the trials, in the unit of the benchmark; more is better
    trial_scores: tuple[float, ...] = ()
    failure: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """A candidate and the configuration to run."""

    candidate: Candidate
    config: Mapping[str, Any]


class Evaluator(Protocol):
    """Where candidates run. Every one gets the same seed and trials."""

    def evaluate(self, orders: Sequence[Order]) -> Iterator[tuple[Order, Evaluated]]:
        """Yield each order when its run has ended; the sequence of the ends has no meaning."""

    def repeat(self, config: Mapping[str, Any], *, seed: int, trials: int) -> Evaluated:
        """Run one configuration with another seed."""


def evaluated(metrics: Mapping[str, Any] | None, failure: str) -> Evaluated:
    """Return how a run with these metrics ended; `failure` is empty if it succeeded."""
    score = (metrics or {}).get("score")
    if failure or score is None:
        return Evaluated(failure=" ".join(failure.split()) or "The run has no score.")
    trials = tuple(trial["score"] for trial in (metrics or {}).get("trials", ()))
    return Evaluated(score=score, trial_scores=trials)
