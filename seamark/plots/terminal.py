"""Charts as text: lines in colours on a terminal, drawn with letters in a pipe."""

from __future__ import annotations

import math
import string
from collections.abc import Sequence
from typing import Any

import numpy as np
import plotille

from seamark.plots.charts import Chart, Numbers
from seamark.sandbox.printable_text import printable_text

COLOURS = {"green": 32, "magenta": 35, "cyan": 36, "yellow": 33, "red": 31}  # ANSI codes
LEAST = 1e-3  # on a logarithmic axis
_MARGIN = 14  # [character] of the y axis with its numbers
_HEIGHT, _MAP_HEIGHT = 14, 20  # [line]
_CELL_ASPECT = 2.0  # height by width of a character
_TICK = 10  # [character] between two numbers of the x axis, as plotille has it
_ROUND = (1.0, 2.0, 2.5, 5.0, 10.0, 20.0)  # steps of an axis, times a power of ten
_DECADES = (1.0, 2.0, 2.5, 10 / 3, 5.0, 10.0, 20.0)  # of a logarithmic axis: parts of a decade
_BLANK = "\N{BRAILLE PATTERN BLANK}"


def text(chart: Chart, *, columns: int, coloured: bool) -> str:
    """Return a chart that is at most `columns` wide."""
    figure = plotille.Figure()
    figure.width = columns - _MARGIN
    figure.height = _MAP_HEIGHT if chart.equal else _HEIGHT
    figure.color_mode, figure.with_colors, figure.origin = "names", coloured, False
    figure.register_label_formatter(float, _Numbers(logarithmic=chart.logarithmic))
    lines = [(line.x, _heights(chart, line.y)) for line in chart.lines]
    if not any(np.isfinite(y).any() for _, y in lines):
        return f"{chart.title}: nothing recorded"
    _set_limits(figure, chart, lines)
    letters = not coloured and len(lines) > 1
    for at, (x, y) in enumerate(lines):
        colour = list(COLOURS)[at % len(COLOURS)] if coloured else None
        marker = string.ascii_lowercase[at] if letters else None
        for part in _stretches(y):
            figure.plot(x[part].tolist(), y[part].tolist(), lc=colour, marker=marker)
    _, *plot, axis, numbers = figure.show().splitlines()
    rows = [
        line.replace(_BLANK, " ").rstrip() for line in (*plot, axis.partition("->")[0], numbers)
    ]
    title = f"{chart.title}    {_legend(chart, coloured=coloured)}".rstrip()
    return "\n".join([title, *rows, chart.x_label.rjust(columns)])


class _Numbers:
    """Writes the numbers of the axes, as plotille asks for them."""

    def __init__(self, *, logarithmic: bool) -> None:
        self._logarithmic = logarithmic

    def __call__(self, val: float, chars: int, delta: float, left: bool) -> str:
        """Return a number: of the x axis if `left`."""
        if left:
            return f"{_rounded(val, delta):.4g}".ljust(chars)
        if self._logarithmic:
            return f"{10.0**val:.2g}".rjust(chars)
        return f"{_rounded(val, delta):.4g}".rjust(chars)


def _rounded(value: float, span: float) -> float:
    """Return 0 for what differs from it by rounding only."""
    return 0.0 if abs(value) < 1e-9 * span else value


def _heights(chart: Chart, y: Numbers) -> Numbers:
    """Return where values are on the y axis; nan for what is not finite."""
    finite = np.where(np.isfinite(y), y, np.nan)
    return np.log10(np.maximum(finite, LEAST)) if chart.logarithmic else finite


def _stretches(y: Numbers) -> list[slice]:
    """Return the stretches of consecutive finite values."""
    finite = np.concatenate([[False], np.isfinite(y), [False]])
    ends = np.flatnonzero(np.diff(finite))
    return [slice(first, end) for first, end in ends.reshape(-1, 2).tolist()]


def _set_limits(figure: Any, chart: Chart, lines: Sequence[tuple[Numbers, Numbers]]) -> None:
    """Fit the axes to the lines, with round numbers; a map has the same scale along both."""
    x, y = (np.concatenate([line[axis] for line in lines]) for axis in (0, 1))
    x, y = x[np.isfinite(y)], y[np.isfinite(y)]
    if not chart.logarithmic and not chart.equal:
        y = np.append(y, 0.0)
    across, down = figure.width / _TICK, figure.height
    x_step = _step(x, across)
    y_step = _step(y, down, rounds=_DECADES if chart.logarithmic else _ROUND)
    if chart.equal:
        x_step = _step(x, across, least=y_step * _TICK / _CELL_ASPECT)
        y_step = x_step * _CELL_ASPECT / _TICK
    figure.set_x_limits(*_limits(x, x_step, across, centred=chart.equal))
    figure.set_y_limits(*_limits(y, y_step, down, centred=chart.equal))


def _step(
    values: Numbers, count: float, *, least: float = 0.0, rounds: Sequence[float] = _ROUND
) -> float:
    """Return the smallest round step of which `count` cover the values from a multiple of it on."""
    low, high = float(values.min()), float(values.max())
    least = max(least, (high - low) / count, 1e-9 * max(abs(low), abs(high)), 1e-9)
    decade = 10.0 ** math.floor(math.log10(least))
    steps = (decade * factor for factor in rounds)
    fitting = (step for step in steps if step >= 0.999 * least)
    return next(step for step in fitting if math.floor(low / step) * step + step * count >= high)


def _limits(values: Numbers, step: float, count: float, *, centred: bool) -> tuple[float, float]:
    low = float(values.min())
    if centred:
        low = 0.5 * (low + float(values.max()) - step * count)
    first = (round(low / step) if centred else math.floor(low / step)) * step
    return first, first + step * count


def _legend(chart: Chart, *, coloured: bool) -> str:
    """Return the names of the lines with their colours or letters."""
    labels = [printable_text(line.label) for line in chart.lines]
    if len(labels) == 1:
        return ""
    if not coloured:
        pairs = zip(string.ascii_lowercase, labels, strict=False)
        return "  ".join(f"{letter}: {label}" for letter, label in pairs)
    codes = list(COLOURS.values())
    return "  ".join(
        f"\x1b[{codes[at % len(codes)]}m── {label}\x1b[0m" for at, label in enumerate(labels)
    )
