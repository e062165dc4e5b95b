"""Metrics and configurations as tables: names, units and values."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from server.pages import fields
from sim.benchmarks import Metric
from sim.metrics import METRICS, POINTS, SETTLING
from sim.sweep import UPDATERS

WHOLE = "whole_"  # prefix of the metrics over a level's whole length
HELD = Metric("held", "Held", "", "higher")
HEAD = (POINTS, HELD, SETTLING)
FIRST = ("rmse_m", "p95_m", "max_m", "rmse_px", "mean_x_px", "mean_y_px", "lost_percent")
# Metric -> one more sentence where the label alone does not say it.
MEANINGS = {
    "points": "100 / (1 + RMSE / 0.25 m) x (1 - share of the time lost)",
    "held": "95 % of the time within 0.5 m, and the target never lost",
    "settling_s": "time from which the distance stays within 0.1 m",
    "rmse_m": "root of the mean square: large errors weigh more",
    "p95_m": "95 % of the time the distance is smaller",
    "mean_x_px": "what a constant current leaves behind along image X (starboard)",
    "mean_y_px": "what a constant current leaves behind along image Y (aft)",
    "itae_m_s2": "late errors cost more",
    "vrx_m": "distance plus weighted heading error, as in the VRX competition",
    "energy_n15_s": "an ideal propeller's power grows with thrust^1.5",
    "collisions": "contacts less than 0.5 s apart count as one",
    "contact_max_n": "the net force on the hull, mean over one control period",
    "variation_m_s": "sum of all changes: how restless the controller is",
}


@dataclass(frozen=True, slots=True)
class Line:
    """One metric over all levels."""

    label: str
    unit: str
    meaning: str
    values: tuple[object, ...]


@dataclass(frozen=True, slots=True)
class Table:
    """The metrics of all levels, one line per metric and one column per level."""

    title: str
    speeds: tuple[float, ...]  # [m/s]
    lines: tuple[Line, ...]


@dataclass(frozen=True, slots=True)
class Option:
    """One chosen setting."""

    title: str
    value: str
    unit: str
    changed: bool


def tables(metrics: Mapping[str, Any], settle_s: float) -> list[Table]:
    """Return the most telling metrics, all of them, and those of whole levels; empty without."""
    levels: Sequence[Mapping[str, Any]] = metrics.get("levels") or []
    if not levels:
        return []
    settled = f"fter the settle window of {fields.text_of(settle_s)} s"
    telling = [metric for metric in METRICS if metric.name in FIRST]
    rest = [metric for metric in METRICS if metric.name not in FIRST]
    return [
        _with_grid(_table("A" + settled, levels, (*HEAD, *telling), prefix=""), levels),
        _table("More metrics, a" + settled, levels, rest, prefix=""),
        _table("Whole levels", levels, METRICS, prefix=WHOLE),
    ]


def _with_grid(table: Table, levels: Sequence[Mapping[str, Any]]) -> Table:
    """Return the table with where in the grid each level is on top, if there is one."""
    lines = tuple(
        Line(what.label, what.unit, "", tuple(level["grid"][name] for level in levels))
        for name in levels[0].get("grid") or {}
        if (what := UPDATERS[name].quantity)
    )
    return replace(table, lines=lines + table.lines)


def trials(metrics: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the trials of a run with more than one."""
    found: list[Mapping[str, Any]] = metrics.get("trials") or []
    return found if len(found) > 1 else []


def options(schema: Mapping[str, Any], config: Mapping[str, Any]) -> dict[str, list[Option]]:
    """Return group -> chosen settings; `changed` marks those that are not the vehicle's default."""
    preset = fields.preset_of(schema, str(config.get("vehicle", "")))
    chosen: dict[str, list[Option]] = {}
    for name, entry in schema["properties"].items():
        if name not in config:
            continue
        text = fields.text_of(config[name])
        shown = {"true": "yes", "false": "no"} if entry["type"] == "boolean" else {}
        label = (entry.get("x-labels") or shown).get(text, text)
        default = fields.text_of(preset.get(name, entry.get("default")))
        option = Option(entry["title"], label, entry.get("x-unit", ""), text != default)
        chosen.setdefault(entry.get("x-group", ""), []).append(option)
    return chosen


def _table(
    title: str, levels: Sequence[Mapping[str, Any]], metrics: Sequence[Metric], *, prefix: str
) -> Table:
    lines = []
    for metric in metrics:
        if prefix + metric.name in levels[0]:
            values = tuple(level.get(prefix + metric.name) for level in levels)
            meaning = MEANINGS.get(metric.name, "")
            lines.append(Line(metric.label, metric.unit, meaning, values))
    return Table(title, tuple(level["speed"] for level in levels), tuple(lines))
