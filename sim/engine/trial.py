"""A trial is one seed through all levels; a run is one or more trials."""

import math
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from seamark.sim import registry
from seamark.sim.engine.experiment import TrialScore
from seamark.sim.metrics import uwsim_metrics
from seamark.sim.metrics.metric import over_run
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
    conditions: Mapping[str, Any] = field(default_factory=dict)  # that were drawn for the trial

    @property
    def overall(self) -> dict[str, Any]:
        """Return the metrics over all levels."""
        return plain(self.trial_score.overall)

    @property
    def measures(self) -> dict[str, Any]:
        """Return the original benchmark module's metrics over all levels."""
        return plain(over_run(uwsim_metrics.METRICS, [level["measures"] for level in self.levels]))

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
        kept.append(rows)
        on_rows(rows)

    plan = experiment.plan(config, seed=seed, trial=trial)
    levels: dict[int, dict[str, Any]] = {}
    rows = 0
    for level in plan.order:
        running = experiment.level(config, solution, seed=seed, trial=trial, level=level)
        with closing(running):
            running.run(deliver)
        whole = np.concatenate(kept)
        digest.add(whole)
        original = uwsim_metrics.level_metrics(whole)
        levels[level] = experiment.metrics(config, level, whole) | {"measures": original}
        rows += len(whole)
        kept.clear()
    listed = tuple(levels[level] for level in sorted(levels))
    return TrialResult(
        trial=trial,
        levels=listed,
        trial_score=experiment.trial_score(config, listed),
        digest=digest.hexdigest(),
        rows=rows,
        conditions=plan.conditions,
    )


def plain(level: Mapping[str, Any]) -> dict[str, Any]:
    """Return metrics for JSON: None for nan and infinity."""
    return {
        name: plain(value)
        if isinstance(value, Mapping)
        else None
        if isinstance(value, float) and not math.isfinite(value)
        else value
        for name, value in level.items()
    }
