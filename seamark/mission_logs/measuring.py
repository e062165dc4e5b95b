"""Measures a log: by the metrics of a benchmark, with the functions that measure its runs."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from seamark.mission_logs.frames import at_target, in_telemetry_frames
from seamark.mission_logs.mapping import LogMapping
from seamark.mission_logs.reading import read
from seamark.mission_logs.result import LOG, WHAT, LogRefused, LogResult
from seamark.mission_logs.rows import LogRows, log_rows
from seamark.mission_logs.scope import check_benchmark
from seamark.mission_logs.timeline import Timeline, timeline
from seamark.sim import registry
from seamark.sim.benchmarks.station_keeping.experiment import StationKeeping
from seamark.sim.camera.target import start_pose
from seamark.sim.engine.experiment import TrialScore
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import TrialResult
from seamark.sim.engine.world import target_and_optics
from seamark.sim.metrics import uwsim_metrics
from seamark.sim.metrics.metric import LevelMetric, over_run
from seamark.sim.numerics.statistics import mean
from seamark.sim.recording.manifest import manifest
from seamark.sim.recording.telemetry import INDEX, Rows, digest
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.settings.station_keeping import StationKeepingSettings
from seamark.sim.vehicles import load

NOT_RANKED = "A log of a real mission is never ranked."
TRIALS_MAX, LEVELS_MAX = 100, 12
_SCORES = ("points", "quality", "near_percent")  # metrics of a level that a score is made of
_CHUNK = 1 << 20


def measure(path: Path, mapping: LogMapping, *, benchmark: str) -> LogResult:
    """Return the rows and the metrics of a log.

    Parameters
    ----------
    path
        A CSV file, an MCAP file, a ROS 1 bag, or a ROS 2 bag: its folder or its file.

    Raises
    ------
    LogRefused
        The log cannot be read or measured; the text says where and why.
    """
    experiment = _experiment(benchmark)
    config = _settings(benchmark, mapping)
    parts, guessed = read(path, mapping)
    merged = timeline(parts, mapping.time)
    frame = mapping.frame or guessed.frame or "NED"
    values = in_telemetry_frames(merged.values, frame)
    target, optics = target_and_optics(config)
    if mapping.target is not None:
        at_target(values, mapping.target, frame, target)
    camera = experiment.camera(config, seed=0, trial=0, level=0)
    made = log_rows(
        merged,
        values,
        camera=camera,
        station=camera.position(start_pose(optics, target, config.altitude_m)),
        counted=config.target_truth,
        thrusters=max(len(load(name).thrusters) for name in config.vehicles()),
    )
    config = _with_times(config, mapping, made.rows, merged.period_s)
    results = _trials(experiment, config, made, scored="levels" in mapping.settings)
    summary = summarise(benchmark, config, results)
    metrics = summary | {"not_ranked": NOT_RANKED, "not_measured": _missing(experiment, made)}
    total = digest(made.rows)
    return LogResult(
        benchmark=benchmark,
        config=config.model_dump(mode="json"),
        trials=len(results),
        rows=made.rows,
        metrics=metrics,
        manifest=manifest(
            benchmark,
            config,
            seed=None,
            trials=len(results),
            controller=LOG,
            digest=total,
            guessed=guessed.document(),
            **_origin(path, mapping, merged, made),
        ),
        digest=total,
    )


def _experiment(name: str) -> StationKeeping[Any]:
    check_benchmark(name)
    loaded: Any = registry.benchmark(name).load()
    if not isinstance(loaded, StationKeeping):
        raise TypeError(f"{name} has settings of station keeping and another experiment")
    return loaded


def _settings(benchmark: str, mapping: LogMapping) -> StationKeepingSettings:
    """Return the settings that the mapping gives, validated; times come from the log."""
    timed = {"control_period_s", "level_duration_s", "score"} & mapping.settings.keys()
    settings = {name: mapping.settings[name] for name in mapping.settings if name not in timed}
    try:
        config: Any = registry.benchmark(benchmark).read(settings)
    except ConfigurationInvalid as error:
        raise LogRefused(f"[settings]: {error}") from None
    levels = config.levels if "levels" in settings else (0.0,)
    checked: StationKeepingSettings = config.model_copy(update={"levels": levels})
    return checked


def _with_times(
    config: StationKeepingSettings, mapping: LogMapping, rows: Rows, period_s: float
) -> StationKeepingSettings:
    """Return the configuration with the log's period, levels and their duration."""
    levels = _whole_numbers(rows, "level", LEVELS_MAX)
    _check_pieces(rows)
    if levels > len(config.level_values()):
        raise LogRefused(
            f"The log has {levels} levels. Name the mean speed of the current of each, in "
            "increasing order, such as levels = [0.1, 0.2] below [settings]."
        )
    if levels < len(config.level_values()):
        raise LogRefused(
            f"[settings] names {len(config.level_values())} levels, but the log has {levels}."
        )
    longest = max(_longest(rows, level) for level in range(levels)) * period_s
    duration_s = round(longest, 9)
    if config.settle_s >= duration_s:
        raise LogRefused(
            f"A level of the log lasts {duration_s:g} s, not longer than the settle window of "
            f"{config.settle_s:g} s. Set settle_s below [settings], for example to 0."
        )
    return config.model_copy(update={"control_period_s": period_s, "level_duration_s": duration_s})


def _whole_numbers(rows: Rows, name: str, most: int) -> int:
    """Return how many trials or levels there are; they are numbered from 0."""
    numbers = np.unique(rows[:, INDEX[name]])
    if len(numbers) > most or not np.array_equal(numbers, np.arange(len(numbers))):
        raise LogRefused(f"{name} must count from 0 without gaps, to at most {most - 1}.")
    return len(numbers)


def _check_pieces(rows: Rows) -> None:
    """Raise LogRefused unless the rows of each level of a trial follow one another."""
    pairs = rows[:, [INDEX["trial"], INDEX["level"]]]
    begins = pairs[np.append(True, (np.diff(pairs, axis=0) != 0.0).any(axis=1))]
    distinct, counts = np.unique(begins, axis=0, return_counts=True)
    if (counts > 1).any():
        trial, level = distinct[int(counts.argmax())].astype(int)
        raise LogRefused(f"In trial {trial} of the log, level {level} is in several pieces.")


def _longest(rows: Rows, level: int) -> int:
    """Return the number of rows of a level, in the trial that has most."""
    trials = rows[rows[:, INDEX["level"]] == level][:, INDEX["trial"]]
    return int(np.unique(trials, return_counts=True)[1].max())


def _trials(
    experiment: StationKeeping[Any],
    config: StationKeepingSettings,
    made: LogRows,
    *,
    scored: bool,
) -> list[TrialResult]:
    numbers = made.rows[:, INDEX["trial"]]
    trials = []
    for trial in range(_whole_numbers(made.rows, "trial", TRIALS_MAX)):
        rows = made.rows[numbers == trial]
        drawn = config.for_trial(trial)
        levels = tuple(
            _level(experiment, drawn, level, rows, made.absent)
            for level in range(len(config.level_values()))
        )
        trials.append(
            TrialResult(
                trial=trial,
                levels=levels,
                trial_score=_score(experiment, drawn, levels, scored=scored),
                digest=digest(rows),
                rows=len(rows),
            )
        )
    return trials


def _level(
    experiment: StationKeeping[Any],
    config: StationKeepingSettings,
    level: int,
    rows: Rows,
    absent: frozenset[str],
) -> dict[str, Any]:
    own = rows[rows[:, INDEX["level"]] == level]
    if not len(own):
        raise LogRefused(f"A trial of the log has no rows of level {level}.")
    original = uwsim_metrics.level_metrics(own, absent=absent)
    return experiment.metrics(config, level, own, absent=absent) | {"measures": original}


def _score(
    experiment: StationKeeping[Any],
    config: StationKeepingSettings,
    levels: Sequence[Mapping[str, Any]],
    *,
    scored: bool,
) -> TrialScore:
    """Return the score by the benchmark's rule, if the currents are known and all is measured."""
    values = [level[name] for level in levels for name in _SCORES if name in level]
    if scored and None not in values:
        score = experiment.trial_score(config, levels)
    else:
        score = TrialScore(
            score=math.nan,
            level_held=None,
            rankable=False,
            overall=over_run(experiment.overall_metrics(), levels),
        )
    return TrialScore(
        score=score.score,
        level_held=score.level_held,
        rankable=False,
        reason=NOT_RANKED,
        overall=score.overall,
    )


def _missing(experiment: StationKeeping[Any], made: LogRows) -> dict[str, list[str]]:
    """Return metric -> the columns that it needs and the log does not have."""
    metrics: Iterable[LevelMetric[Any]] = (
        *experiment.overall_metrics(),
        *uwsim_metrics.METRICS,
    )
    return {
        metric.name: sorted(made.absent & set(metric.reads))
        for metric in metrics
        if made.absent & set(metric.reads)
    }


def _origin(path: Path, mapping: LogMapping, merged: Timeline, made: LogRows) -> dict[str, Any]:
    """Return what the manifest says about the log."""
    jitter = np.diff(merged.t) - merged.period_s
    return {
        "kind": WHAT,
        "log": {"name": path.name, "sha256": _sha256(path)},
        "mapping": mapping.model_dump(mode="json", exclude_defaults=True),
        "period_s": merged.period_s,
        "resampled": merged.resampled,
        "mean_jitter_s": round(mean(np.abs(jitter[jitter > -merged.period_s]).tolist()), 6),
        "measured": list(made.measured),
        "derived": list(made.derived),
        "absent": sorted(made.absent),
    }


def _sha256(path: Path) -> str:
    """Return the SHA-256 of a file; of a folder, over its files in order of their names."""
    total = hashlib.sha256()
    files = sorted(one for one in path.iterdir() if one.is_file()) if path.is_dir() else [path]
    for file in files:
        with file.open("rb") as stream:
            while chunk := stream.read(_CHUNK):
                total.update(chunk)
    return total.hexdigest()
