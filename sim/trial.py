"""A trial: one seed through all levels. And the summary of several trials."""

import math
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.benchmarks.currents_v1 import CurrentsConfiguration
from sim.configuration import Configuration
from sim.loop import LevelLoop, OnRows
from sim.metrics import LevelFacts, level_metrics, mean_over_trials
from sim.program import Program
from sim.registry import BENCHMARKS
from sim.statistics import bootstrap_interval, mean
from sim.telemetry import Digest, Recorder, Rows
from sim.vehicles import load
from sim.world import world_of

TICKS_PER_DELIVERY = 20  # 1 s simulated at 20 Hz


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialResult:
    """What a trial ended with. `seed` is left out on purpose: it may be a hidden one."""

    trial: int
    levels: tuple[Mapping[str, Any], ...]  # one dictionary of `sim.metrics.level_metrics` per level
    digest: str  # SHA-256 of this trial's telemetry
    rows: int

    @property
    def score(self) -> float:
        """Return the mean of the levels' points, 0 to 100."""
        return mean([float(level["points"]) for level in self.levels])

    @property
    def level_held(self) -> float | None:
        """Return the speed [m/s] up to which every level was held; None if not even the first."""
        held: float | None = None
        for level in self.levels:
            if not level["held"]:
                break
            held = float(level["speed"])
        return held

    @property
    def rankable(self) -> bool:
        """Whether the score is a number and the target was not lost all the time at any level."""
        all_lost = any(level["whole_lost_percent"] >= 100.0 for level in self.levels)
        return math.isfinite(self.score) and not all_lost


def run_trial(
    benchmark: str,
    config: Configuration,
    program: Program,
    *,
    seed: int,
    trial: int,
    on_rows: OnRows,
) -> TrialResult:
    """Run all levels and return the metrics.

    Rows, (k, WIDTH), go to `on_rows` in order, every 20 control ticks and at the end; also when the
    program raises, so that what happened until then is never lost.

    Raises
    ------
    KeyError
        If there is no such benchmark.
    Exception
        Whatever the program raises, untouched.
    """
    if benchmark not in BENCHMARKS:
        raise KeyError(f"there is no benchmark {benchmark!r}")
    if not isinstance(config, CurrentsConfiguration):
        raise TypeError(f"{benchmark} cannot run a {type(config).__name__}")
    recorder, digest = Recorder(TICKS_PER_DELIVERY), Digest()
    kept: list[Rows] = []

    def deliver(rows: Rows) -> None:
        digest.add(rows)
        kept.append(rows)
        on_rows(rows)

    levels = []
    try:
        for level in range(len(config.levels)):
            with closing(world_of(config, seed=seed, trial=trial, level=level)) as world:
                LevelLoop(world, program, trial=trial, level=level).run(recorder, deliver)
            _deliver_rest(recorder, deliver)
            levels.append(level_metrics(np.concatenate(kept), _facts(config, level)))
            kept.clear()
    finally:
        _deliver_rest(recorder, deliver)
    return TrialResult(
        trial=trial,
        levels=tuple(levels),
        digest=digest.hexdigest(),
        rows=len(config.levels) * config.ticks_per_level,
    )


def _deliver_rest(recorder: Recorder, deliver: OnRows) -> None:
    rest = recorder.take()
    if len(rest):
        deliver(rest)


def _facts(config: CurrentsConfiguration, level: int) -> LevelFacts:
    forward, reverse = load(config.vehicle).curve.limits.value
    return LevelFacts(
        level=level,
        speed=config.levels[level],
        dt=config.control_period_s,
        settle_s=config.settle_s,
        limits_n=(forward, reverse),
    )


def summarise(
    benchmark: str, config: Configuration, results: Sequence[TrialResult]
) -> dict[str, Any]:
    """Return metrics.json: the score with its interval, every trial, the mean per level.

    `score_low` and `score_high` are the 95 % bootstrap interval of the mean; None for one trial.
    `rankable` is false when a trial gave no number or lost its target for a whole level.
    """
    scores = [result.score for result in results]
    interval = bootstrap_interval(scores) if all(map(math.isfinite, scores)) else None
    rankable = bool(results) and all(result.rankable for result in results)
    held = [result.level_held for result in results]
    return {
        "benchmark": benchmark,
        "score": mean(scores) if scores and all(map(math.isfinite, scores)) else None,
        "score_low": interval[0] if interval else None,
        "score_high": interval[1] if interval else None,
        "rankable": rankable,
        "level_held": _lowest(held),
        "trials": [_entry(result) for result in results],
        "levels": [
            mean_over_trials([_plain(level) for level in same])
            for same in zip(*(result.levels for result in results), strict=True)
        ],
    }


def _lowest(held: Sequence[float | None]) -> float | None:
    known = [speed for speed in held if speed is not None]
    return min(known) if known and len(known) == len(held) else None


def _plain(level: Mapping[str, Any]) -> dict[str, Any]:
    """Return metrics as JSON knows them: None for what is no number."""
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in level.items()
    }


def _entry(result: TrialResult) -> dict[str, Any]:
    return {
        "trial": result.trial,
        "score": result.score if math.isfinite(result.score) else None,
        "level_held": result.level_held,
        "rankable": result.rankable,
        "digest": result.digest,
        "levels": [_plain(level) for level in result.levels],
    }
