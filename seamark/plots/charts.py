"""What plots show: lines with labels, from the results of one or several runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.failures import UsageRefused
from seamark.plots.result import Result
from seamark.sim import registry

PICTURE_POINTS = 2000  # of a line, in a picture
Numbers = NDArray[np.float64]
REACH = "reach"  # of runs with an arm
ERRORS = {  # title and unit, by the column of the benchmark
    "distance": ("Distance from the station", "m"),
    "tracker_error": ("Error of the tracker", "px"),
    REACH: ("Distance of the tool from the grip", "m"),
}
# Kinds of charts that runs without an error do not have: single images, on a prescribed path.
OF_AN_ERROR = frozenset({"error", "current"})


@dataclass(frozen=True, slots=True)
class Line:
    """A line; its points are in order."""

    label: str
    x: Numbers
    y: Numbers


@dataclass(frozen=True, slots=True, kw_only=True)
class Chart:
    """Lines over the same axes."""

    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    logarithmic: bool = False  # the y axis
    equal: bool = False  # both axes have the same scale

    def to_json(self) -> dict[str, Any]:
        """Return the chart as JSON values; None for what is not finite."""
        return {
            "title": self.title,
            "x_label": self.x_label,
            "y_label": self.y_label,
            "lines": [
                {"label": one.label, "x": _finite(one.x), "y": _finite(one.y)} for one in self.lines
            ],
        }


def _finite(values: Numbers) -> list[float | None]:
    return [value if np.isfinite(value) else None for value in values.tolist()]


def _error(results: Sequence[Result], trial: int, points: int) -> Chart:
    """Return the error over time; of each stretch of time the largest, so that no peak is lost."""
    benchmark = registry.benchmark(results[0].benchmark)
    column = REACH if benchmark.moves_arm else benchmark.error_column
    assert column is not None  # noqa: S101 - `charts` leaves this kind out
    title, unit = ERRORS[column]
    lines = []
    for result in results:
        rows = result.trial(trial)
        at = _stretches(len(rows), points)
        worst = np.fmax.reduceat(rows[column], at) if len(at) else rows[column]
        lines.append(Line(result.name, rows["t"][at], worst))
    return Chart(
        title=f"{title} [{unit}]",
        x_label="time [s]",
        y_label=f"{title} [{unit}]",
        lines=tuple(lines),
        logarithmic=True,
    )


def _current(results: Sequence[Result], trial: int, points: int) -> Chart:
    """Return the speed of the current over time, once where runs have the same seed."""
    lines: list[Line] = []
    for result in results:
        rows = result.trial(trial)
        at = _stretches(len(rows), points)
        speed = np.sqrt(sum(rows[name] ** 2 for name in ("current_x", "current_y", "current_z")))
        mean = np.add.reduceat(speed, at) / np.diff([*at, len(rows)]) if len(at) else speed
        line = Line(result.name, rows["t"][at], mean)
        if not any(np.array_equal(line.y, other.y) for other in lines):
            lines.append(line)
    shared = ", the same for all" if len(lines) == 1 < len(results) else ""
    return Chart(
        title=f"Current{shared} [m/s]",
        x_label="time [s]",
        y_label="Current [m/s]",
        lines=tuple(lines),
    )


def _path(results: Sequence[Result], trial: int, points: int) -> Chart:
    """Return the path, with a gap where a level begins and the vehicle is put at the station."""
    lines = []
    for result in results:
        rows = result.trial(trial)
        at = _stretches(len(rows), points)
        gaps = np.flatnonzero(np.diff(rows["level"][at])) + 1
        east, north = (np.insert(rows[name][at], gaps, np.nan) for name in ("y", "x"))
        lines.append(Line(result.name, east, north))
    return Chart(
        title="Path of the vehicle from above [m]",
        x_label="east [m]",
        y_label="north [m]",
        lines=tuple(lines),
        equal=True,
    )


def _levels(results: Sequence[Result], trial: int, points: int) -> Chart:
    """Return the benchmark's first key metric of each level, as the mean over all trials."""
    benchmark = registry.benchmark(results[0].benchmark)
    metric = benchmark.key_metrics[0]
    config = benchmark.restore(results[0].manifest["configuration"])
    quantity = config.level_metric()
    unit = f" [{metric.unit}]" if metric.unit else ""
    lines = []
    for result in results:
        levels = (result.metrics or {}).get("levels") or []
        values = benchmark.restore(result.manifest["configuration"]).level_values()
        pairs = sorted(
            (value, level[metric.name])
            for value, level in zip(values, levels, strict=False)
            if level.get(metric.name) is not None
        )
        x, y = np.array(pairs, dtype=float).reshape(-1, 2).T
        lines.append(Line(result.name, x, y))
    return Chart(
        title=f"{metric.label}{unit} of each level",
        x_label=f"{quantity.label} [{quantity.unit}]" if quantity.unit else quantity.label,
        y_label=f"{metric.label}{unit}",
        lines=tuple(lines),
    )


KINDS: Mapping[str, Callable[[Sequence[Result], int, int], Chart]] = {
    "error": _error,
    "current": _current,
    "path": _path,
    "levels": _levels,
}


def charts(
    results: Sequence[Result], *, kinds: Sequence[str], trial: int, points: int
) -> list[Chart]:
    """Return the charts of these kinds, with at most `points` points a line.

    Raises
    ------
    UsageRefused
        The runs are of different benchmarks, or have no such trial or no such chart.
    """
    names = list(dict.fromkeys(result.benchmark for result in results))
    if len(names) > 1:
        raise UsageRefused(f"Plots need runs of one benchmark, not of {' and '.join(names)}.")
    if names[0] not in registry.BENCHMARKS:
        raise UsageRefused(f"This version of Seamark does not know the benchmark {names[0]}.")
    for result in results:
        if not len(result.trial(trial)):
            count = len(np.unique(result.rows["trial"]))
            trials = "1 trial" if count == 1 else f"{count} trials"
            raise UsageRefused(f"{result.name} has {trials}, counted from 1.")
    without_error = registry.benchmark(names[0]).error_column is None
    shown = [kind for kind in kinds if not (without_error and kind in OF_AN_ERROR)]
    if not shown:
        raise UsageRefused(f"Runs of {names[0]} have no chart of this kind: choose another.")
    return [KINDS[kind](results, trial, points) for kind in shown]


def _stretches(count: int, points: int) -> NDArray[np.intp]:
    """Return where each of at most `points` equal stretches of `count` rows begins."""
    step = max(1, -(-count // points))
    return np.arange(0, count, step)
