"""Metrics and configurations as tables: names, units and values."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from seamark.server.pages import form_fields
from seamark.server.web.template_filters import plain
from seamark.sim.benchmarks import benchmark
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.metrics.metric import Metric
from seamark.sim.settings.grid import UPDATERS

MOST_COLUMNS = 12


@dataclass(frozen=True, slots=True)
class Line:
    """One metric over all levels."""

    label: str
    unit: str
    meaning: str
    values: tuple[object, ...]


@dataclass(frozen=True, slots=True)
class Table:
    """The metrics of all levels, one line per metric."""

    title: str
    value: Metric  # what a level's value is
    levels: tuple[float, ...]  # the value of each
    lines: tuple[Line, ...]

    @property
    def tall(self) -> bool:
        """Whether there are too many levels for a column each: they are the rows then."""
        return len(self.levels) > MOST_COLUMNS


@dataclass(frozen=True, slots=True)
class Option:
    """One chosen setting."""

    title: str
    value: str
    unit: str
    changed: bool


def tables(
    benchmark: Benchmark, config: Mapping[str, Any], metrics: Mapping[str, Any]
) -> list[Table]:
    """Return the benchmark's tables of a run's metrics; empty without."""
    levels: Sequence[Mapping[str, Any]] = metrics.get("levels") or []
    if not levels:
        return []
    value = benchmark.restore(config).level_metric()
    first, *more = (_table(table, levels, value, config) for table in benchmark.tables)
    return [_with_grid(first, levels, value.label), *more]


def facts(benchmark: Benchmark, metrics: Mapping[str, Any]) -> list[Line]:
    """Return the metrics over all levels."""
    overall: Mapping[str, Any] = metrics.get("overall") or {}
    return [
        Line(metric.label, metric.unit, metric.meaning, (overall[metric.name],))
        for metric in benchmark.overall
        if metric.name in overall
    ]


def _with_grid(table: Table, levels: Sequence[Mapping[str, Any]], head: str) -> Table:
    """Return the table with where in the grid each level is on top, beside what its head says."""
    lines = tuple(
        Line(what.label, what.unit, "", tuple(plain(level["grid"][name]) for level in levels))
        for name in levels[0].get("grid") or {}
        if (what := UPDATERS[name].quantity).label != head
    )
    return replace(table, lines=lines + table.lines)


def trials(metrics: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the trials of a run with more than one."""
    found: list[Mapping[str, Any]] = metrics.get("trials") or []
    return found if len(found) > 1 else []


def options(schema: Mapping[str, Any], config: Mapping[str, Any]) -> dict[str, list[Option]]:
    """Return group -> chosen settings that do anything; `changed` marks those not the default."""
    preset = form_fields.preset_of(schema, config)
    chosen: dict[str, list[Option]] = {}
    for name, entry in schema["properties"].items():
        if name not in config or not form_fields.applying(entry, config):
            continue
        text = form_fields.text_of(config[name])
        shown = {"true": "yes", "false": "no"} if entry["type"] == "boolean" else {}
        label = (entry.get("x-labels") or shown).get(text, text)
        default = form_fields.text_of(preset.get(name, entry.get("default")))
        option = Option(entry["title"], label, entry.get("x-unit", ""), text != default)
        chosen.setdefault(entry.get("x-group", ""), []).append(option)
    return chosen


def _table(
    table: benchmark.Table,
    levels: Sequence[Mapping[str, Any]],
    value: Metric,
    config: Mapping[str, Any],
) -> Table:
    lines = []
    at = tuple(level[value.name] for level in levels)
    for metric in table.metrics:
        name = table.prefix + metric.name
        values = tuple(level.get(name) for level in levels)
        if name in levels[0] and values != at:  # what the levels set is in the head already
            lines.append(Line(metric.label, metric.unit, metric.meaning, values))
    title = table.title.format(**config)
    return Table(title, value, at, tuple(lines))
