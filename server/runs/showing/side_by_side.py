"""Runs side by side: the settings that differ, the scores, the metrics with the best marked."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from seamark.programs.parameters import KEY, split
from seamark.programs.setting_values import in_effect, label_of, text_of
from seamark.server.runs.record.solutions import team
from seamark.server.runs.showing.score_differences import (
    ComparedRun,
    ScoreDifference,
    SeedsOf,
    differing_scenario,
    headline_of,
    score_difference,
)
from seamark.sim import registry
from seamark.sim.metrics.metric import Metric

RUNS_MIN, RUNS_MAX = 2, 5
COLUMNS_MAX = 8  # telemetry columns that are overlaid at once
DIGEST = "program_sha256"  # a setting for programs; people read the lines that differ
_DIGEST_SHOWN = 12  # [character] of a SHA-256
_ALIKE = 1e-3  # relative difference of values that are equally good


@dataclass(frozen=True, slots=True)
class SettingRow:
    """A setting in which the runs differ: one value per run; None where it has no effect."""

    name: str
    title: str
    unit: str
    values: tuple[str | None, ...]


@dataclass(frozen=True, slots=True)
class MetricRow:
    """A metric: one value per run, and the positions of the best ones.

    `level` is empty for a metric over all levels.
    """

    label: str
    unit: str
    level: str
    values: tuple[float | None, ...]
    best: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SideBySide:
    """What differs between runs. Scores are compared with the first run."""

    settings: tuple[SettingRow, ...]
    scores: tuple[ScoreDifference, ...]
    metrics: tuple[MetricRow, ...]
    levels: tuple[str, ...]  # names of the levels; empty if the runs have different ones
    note: str  # why no value is marked as the best; empty if they are


def side_by_side(runs: Sequence[ComparedRun], seeds_of: SeedsOf) -> SideBySide:
    """Compare two to five runs of benchmarks in the registry."""
    note = _note(runs)
    levels = _common_levels(runs)
    return SideBySide(
        settings=tuple(row for row in _settings(runs) if len(set(row.values)) > 1),
        scores=tuple(score_difference(run, runs[0], seeds_of) for run in runs[1:]),
        metrics=tuple(_metrics(runs, levels, marked=not note)),
        levels=levels,
        note=note,
    )


def _note(runs: Sequence[ComparedRun]) -> str:
    names = list(dict.fromkeys(run.benchmark for run in runs))
    if len(names) > 1:
        return (
            f"These are runs of {' and '.join(names)}. Their telemetry and cameras can be "
            "compared, their scores and metrics cannot."
        )
    differing = dict.fromkeys(
        title for run in runs[1:] for title in differing_scenario(runs[0], run)
    )
    if differing:
        return (
            f"The scenarios differ ({', '.join(differing)}), so the metrics compare more than the "
            "solutions, and none is marked as the best."
        )
    return ""


# -- settings -----------------------------------------------------------------------------------
def _settings(runs: Sequence[ComparedRun]) -> list[SettingRow]:
    rows = [
        SettingRow("benchmark", "Benchmark", "", tuple(run.benchmark for run in runs)),
        SettingRow("kind", "Kind", "", tuple(str(run.kind) for run in runs)),
        SettingRow("solution", "Solution", "", tuple(team(run) for run in runs)),
        SettingRow(DIGEST, "Program, SHA-256", "", tuple(map(_program, runs))),
        *_parts(runs),
        SettingRow("seed", "Seed", "", tuple(map(_seed, runs))),
        SettingRow("trials", "Trials", "", tuple(str(run.trials) for run in runs)),
    ]
    values = [_values(run) for run in runs]
    entries = {name: entry for run in runs for name, entry in _schema(run).items()}
    for name, entry in entries.items():
        texts = tuple(each.get(name) for each in values)
        rows.append(SettingRow(name, entry["title"], entry.get("x-unit", ""), texts))
    return rows + _parameters(runs)


def _parameters(runs: Sequence[ComparedRun]) -> list[SettingRow]:
    """Return the parameters of the runs' own programs."""
    values = [split(run.config)[1] for run in runs]
    return [
        SettingRow(
            f"{KEY}.{name}",
            name,
            "",
            tuple(text_of(each[name]) if name in each else None for each in values),
        )
        for name in dict.fromkeys(name for each in values for name in each)
    ]


def _program(run: ComparedRun) -> str | None:
    return run.program_sha256 and run.program_sha256[:_DIGEST_SHOWN]


def _parts(runs: Sequence[ComparedRun]) -> list[SettingRow]:
    """Return the digests of the programs in further roles."""
    of_runs = [
        {part.role: part.program_sha256[:_DIGEST_SHOWN] for part in run.parts} for run in runs
    ]
    return [
        SettingRow(
            f"{role}_{DIGEST}",
            f"Own {role}, SHA-256",
            "",
            tuple(digests.get(role) for digests in of_runs),
        )
        for role in dict.fromkeys(role for digests in of_runs for role in digests)
    ]


def _roles(run: ComparedRun) -> list[str]:
    return [part.role for part in run.parts]


def _seed(run: ComparedRun) -> str | None:
    return None if run.seed is None else str(run.seed)


def _schema(run: ComparedRun) -> Mapping[str, Any]:
    properties: Mapping[str, Any] = registry.benchmark(run.benchmark).schema()["properties"]
    return properties


def _values(run: ComparedRun) -> dict[str, str]:
    """Return name -> text of the settings that have an effect."""
    benchmark = registry.benchmark(run.benchmark)
    config = benchmark.restore(run.config).model_dump()
    effective = in_effect(benchmark, config, run.controller, parts=_roles(run))
    return {name: label_of(entry, config[name]) for name, entry in effective.items()}


# -- metrics ------------------------------------------------------------------------------------
def _metrics(
    runs: Sequence[ComparedRun], levels: Sequence[str], *, marked: bool
) -> list[MetricRow]:
    """Return the score, the metrics over all levels and the key metrics of each level."""
    if len({run.benchmark for run in runs}) > 1:
        return []
    benchmark = registry.benchmark(runs[0].benchmark)
    rows: list[MetricRow] = []
    if len({headline_of(run).label for run in runs}) == 1:
        rows.append(_row(headline_of(runs[0]), [run.score for run in runs], marked=marked))
    main = [metric for table in benchmark.tables[:2] for metric in table.metrics]
    overall = [(run.metrics or {}).get("overall") or {} for run in runs]
    rows += [
        _row(metric, [values.get(metric.name) for values in overall], marked=marked)
        for metric in benchmark.overall or main
    ]
    rows = [row for at, row in enumerate(rows) if at == 0 or row.values != rows[0].values]
    for index, level in enumerate(levels):
        at = [_level(run, index) for run in runs]
        rows += [
            _row(metric, [values.get(metric.name) for values in at], marked=marked, level=level)
            for metric in benchmark.key_metrics
        ]
    return [row for row in rows if any(value is not None for value in row.values)]


def _level(run: ComparedRun, index: int) -> Mapping[str, Any]:
    levels: Sequence[Mapping[str, Any]] = (run.metrics or {}).get("levels") or []
    return levels[index] if index < len(levels) else {}


def _row(metric: Metric, values: Sequence[Any], *, marked: bool, level: str = "") -> MetricRow:
    numbers = tuple(None if value is None else float(value) for value in values)
    best = _best(metric, numbers) if marked else ()
    return MetricRow(metric.label, metric.unit, level, numbers, best)


def _best(metric: Metric, values: Sequence[float | None]) -> tuple[int, ...]:
    """Return the positions of the best values; none if all are equally good.

    Values are equally good if they look alike with three digits.
    """
    # Of a signed error, such as a mean along an axis, the one nearest to 0 is the best.
    merit = [
        None if value is None else value if metric.better == "higher" else -abs(value)
        for value in values
    ]
    known = [value for value in merit if value is not None]
    if len(known) < 2:
        return ()
    best = [
        at
        for at, value in enumerate(merit)
        if value is not None and math.isclose(value, max(known), rel_tol=_ALIKE)
    ]
    return tuple(best) if len(best) < len(known) else ()


def _common_levels(runs: Sequence[ComparedRun]) -> tuple[str, ...]:
    names = {level_labels(run) for run in runs}
    return names.pop() if len(names) == 1 else ()


def level_labels(run: ComparedRun) -> tuple[str, ...]:
    """Return a name for each level of a run, such as "0.4 m/s"."""
    config = registry.benchmark(run.benchmark).restore(run.config)
    unit = config.level_metric().unit
    return config.level_names() or tuple(f"{v:g} {unit}".rstrip() for v in config.level_values())
