"""Tables of the metrics and the configuration of a run."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from seamark.programs import parameters
from seamark.programs.parameters import Parameter
from seamark.programs.setting_values import in_effect, label_of, text_of
from seamark.server.pages.benchmark import form_fields
from seamark.server.runs.showing.views import RunView
from seamark.server.web.template_filters import plain
from seamark.sim.benchmarks import benchmark
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.metrics.metric import LevelMetric, Metric
from seamark.sim.settings.grid import UPDATERS

COLUMNS_MAX = 12


@dataclass(frozen=True, slots=True)
class Row:
    """The values of one metric, one per level, or a single value over all levels."""

    name: str  # in metrics.json
    label: str
    unit: str
    meaning: str
    values: tuple[object, ...]


@dataclass(frozen=True, slots=True)
class Table:
    """Metrics by level, one row per metric."""

    title: str
    level: Metric  # label and unit of the level values
    levels: tuple[str, ...]  # names or values of the levels
    rows: tuple[Row, ...]

    @property
    def tall(self) -> bool:
        """Whether there are too many levels for columns, so that the table is transposed."""
        return len(self.levels) > COLUMNS_MAX


@dataclass(frozen=True, slots=True)
class SettingValue:
    """One setting of a run."""

    title: str
    value: str
    unit: str
    changed: bool  # from the default


def tables(
    benchmark: Benchmark, config: Mapping[str, Any], metrics: Mapping[str, Any]
) -> list[Table]:
    """Return the tables of a run; empty if it has no metrics."""
    levels: Sequence[Mapping[str, Any]] = metrics.get("levels") or []
    if not levels:
        return []
    restored = benchmark.restore(config)
    level, names = restored.level_metric(), restored.level_names()
    described = (_table(table, levels, level, config) for table in benchmark.tables)
    first, *others = (replace(table, levels=names or table.levels) for table in described)
    return [_with_grid(first, levels, level.label), *others]


def overall(benchmark: Benchmark, metrics: Mapping[str, Any]) -> list[Row]:
    """Return the metrics over all levels."""
    values: Mapping[str, Any] = metrics.get("overall") or {}
    return [
        Row(
            metric.name,
            benchmark.overall_label(metric),
            metric.unit,
            _meaning(metric),
            (values[metric.name],),
        )
        for metric in benchmark.overall
        if metric.name in values
    ]


def level_held_meaning(benchmark: Benchmark) -> str:
    """Return what the highest level held is: the benchmark says when a level is held."""
    metrics = (metric for table in benchmark.tables for metric in table.metrics)
    held = next((metric.meaning for metric in metrics if metric.name == "held"), "")
    return f"the last one up to which all levels are held: {held}" if held else ""


def trials(metrics: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the metrics of each trial; empty for a run with a single trial."""
    of_trials: list[Mapping[str, Any]] = metrics.get("trials") or []
    return of_trials if len(of_trials) > 1 else []


def settings(
    benchmark: Benchmark,
    config: Mapping[str, Any],
    controller: str,
    *,
    parts: Sequence[str] = (),
) -> dict[str, list[SettingValue]]:
    """Return group -> settings of a run that have an effect with its solution and its parts."""
    preset = form_fields.preset_of(benchmark.schema(), config)
    groups: dict[str, list[SettingValue]] = {}
    for name, entry in in_effect(benchmark, config, controller, parts=parts).items():
        default = text_of(preset.get(name, entry.get("default")))
        changed = text_of(config[name]) != default
        label = label_of(entry, config[name])
        value = SettingValue(entry["title"], label, entry.get("x-unit", ""), changed)
        groups.setdefault(entry.get("x-group", ""), []).append(value)
    return groups


def program_parameters(run: RunView) -> list[SettingValue]:
    """Return the parameters of a run's own program, with what it declares of them."""
    declared = {one["name"]: Parameter.from_json(one) for one in run.program_parameters or ()}
    values = []
    for name, value in parameters.split(run.config)[1].items():
        one, text = declared.get(name), text_of(value)
        changed = one is not None and text != text_of(one.default)
        values.append(SettingValue(name, text, "" if one is None else one.unit, changed))
    return values


def _meaning(metric: Metric) -> str:
    """Return what a metric over the run is, with how it comes from the levels."""
    how = metric.over.description if isinstance(metric, LevelMetric) else ""
    return "; ".join(filter(None, (metric.meaning, how)))


def _table(
    table: benchmark.Table,
    levels: Sequence[Mapping[str, Any]],
    level_metric: Metric,
    config: Mapping[str, Any],
) -> Table:
    rows = []
    level_values = tuple(level[level_metric.name] for level in levels)
    for metric in table.metrics:
        name = table.prefix + metric.name
        values = tuple(level.get(name) for level in levels)
        in_header = len(levels) > 1 and values == level_values
        if name in levels[0] and not in_header:
            rows.append(Row(name, metric.label, metric.unit, metric.meaning, values))
    shown = tuple(map(plain, level_values))
    return Table(table.title.format(**config), level_metric, shown, tuple(rows))


def _with_grid(table: Table, levels: Sequence[Mapping[str, Any]], header: str) -> Table:
    """Return the table with the grid coordinates of each level, except the one in the header."""
    rows = tuple(
        Row(
            name,
            quantity.label,
            quantity.unit,
            "",
            tuple(plain(level["grid"][name]) for level in levels),
        )
        for name in levels[0].get("grid") or {}
        if (quantity := UPDATERS[name].quantity).label != header
    )
    return replace(table, rows=rows + table.rows)
