"""How much the scores of two runs differ, paired where their trials have the same conditions."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from seamark.server.runs.record.seeds import Seeded
from seamark.server.runs.record.solutions import HasSolution
from seamark.server.runs.record.trial_scores import block_of, trial_scores
from seamark.sim import registry
from seamark.sim.engine.seeds import FRESH
from seamark.sim.metrics.metric import Metric
from seamark.sim.numerics.statistics import difference_interval, mean, paired_interval


class ComparedRun(Seeded, HasSolution, Protocol):
    """A run that is compared with others: the view of one on a server, or a local result."""

    @property
    def id(self) -> int:
        """Its number."""

    @property
    def kind(self) -> str:
        """Practice or ranked."""

    @property
    def state(self) -> str:
        """How far it is."""

    @property
    def trials(self) -> int:
        """The number of trials."""

    @property
    def score(self) -> float | None:
        """The score; None before the end, and if it failed."""

    @property
    def metrics(self) -> Mapping[str, Any] | None:
        """What metrics.json has; None without a score."""


SeedsOf = Callable[[ComparedRun], Callable[[int], int]]  # run -> trial -> seed


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreDifference:
    """The score of a run minus that of another one; None where it says nothing."""

    run: int
    other: int
    paired_trials: int = 0  # 0: the trials are independent
    difference: float | None = None  # in the unit of the score
    low: float | None = None  # of the 95 % interval
    high: float | None = None
    sentence: str  # how it was computed, or why not


def score_difference(run: ComparedRun, other: ComparedRun, seeds_of: SeedsOf) -> ScoreDifference:
    """Return the difference of the scores of two runs of benchmarks in the registry.

    Trials that share water, seed and number in the same scenario, are compared one by one: what
    they have in common cancels out. Otherwise the scores are means of independent samples.
    """
    ids = {"run": run.id, "other": other.id}
    if reason := _not_comparable(run, other):
        return ScoreDifference(**ids, sentence=reason)
    own, its = paired_scores(run, other, seeds_of)
    block = block_of(run.benchmark)
    if own:
        low, high = paired_interval(own, its, block=block) or (None, None)
        return ScoreDifference(
            **ids,
            paired_trials=len(own),
            difference=mean(own) - mean(its),
            low=low,
            high=high,
            sentence=_pairs(len(own), known=low is not None),
        )
    low, high = difference_interval(_scores(run), _scores(other), block=block) or (None, None)
    return ScoreDifference(
        **ids,
        difference=(run.score or 0.0) - (other.score or 0.0),
        low=low,
        high=high,
        sentence=_independent(run, other, known=low is not None),
    )


def paired_scores(
    run: ComparedRun, other: ComparedRun, seeds_of: SeedsOf
) -> tuple[list[float], list[float]]:
    """Return the scores of the trials that two runs have in the same conditions; else none."""
    if run.benchmark != other.benchmark or differing_scenario(run, other):
        return [], []
    own, its = _score_of_trial(run), _score_of_trial(other)
    seeds, others = seeds_of(run), seeds_of(other)
    shared = [trial for trial in own if trial in its and seeds(trial) == others(trial)]
    return [own[trial] for trial in shared], [its[trial] for trial in shared]


def differing_scenario(run: ComparedRun, other: ComparedRun) -> list[str]:
    """Return the titles of the scenario's settings that differ; of one benchmark."""
    benchmark = registry.benchmark(run.benchmark)
    first, second = (benchmark.restore(each.config).model_dump() for each in (run, other))
    return [
        entry["title"]
        for name, entry in benchmark.schema()["properties"].items()
        if entry["x-role"] == "scenario" and first.get(name) != second.get(name)
    ]


def headline_of(run: ComparedRun) -> Metric:
    """Return the metric that the score of a run is."""
    benchmark = registry.benchmark(run.benchmark)
    return benchmark.headline_of(benchmark.restore(run.config))


def _not_comparable(run: ComparedRun, other: ComparedRun) -> str:
    """Return why the scores cannot be compared, empty if they can."""
    if run.benchmark != other.benchmark:
        return (
            f"Scores of {run.benchmark} and {other.benchmark} measure different things. Compare "
            "runs of one benchmark to see the difference."
        )
    names = [headline_of(each).label for each in (run, other)]
    if names[0] != names[1]:
        return f"The scores are different metrics: {names[0]} and {names[1]}."
    for each in (run, other):
        if each.score is None:
            return f"Run {each.id} has no score: it is {each.state}."
    return ""


def _score_of_trial(run: ComparedRun) -> Mapping[int, float]:
    """Return trial -> score; empty if one of them has none."""
    trials: Sequence[Mapping[str, Any]] = (run.metrics or {}).get("trials", ())
    scores = {number: trial["score"] for number, trial in enumerate(trials)}
    return {} if any(score is None for score in scores.values()) else scores


def _scores(run: ComparedRun) -> list[float]:
    return [score for score in trial_scores(run.metrics, FRESH) if math.isfinite(score)]


def _pairs(trials: int, *, known: bool) -> str:
    if known:
        return f"The runs are compared over {trials} trials in the same conditions."
    count = "one trial" if trials == 1 else f"{trials} trials"
    return f"The runs share {count} in the same conditions, which is too few for an interval."


def _independent(run: ComparedRun, other: ComparedRun, *, known: bool) -> str:
    counts = f"{len(_scores(run))} and {len(_scores(other))} trials"
    method = "the interval is from Welch's t test" if known else "they are too few for an interval"
    text = f"The runs have {counts} in different conditions; {method}."
    if differing := differing_scenario(run, other):
        text += f" The scenarios differ as well: {', '.join(differing)}."
    return text
