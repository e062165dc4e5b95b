"""Charts as a picture: PNG, PDF or SVG, without a window."""

from __future__ import annotations

from collections.abc import Sequence
from typing import BinaryIO

from matplotlib.figure import Figure

from seamark.plots.charts import Chart

_SIZE_IN = (6.0, 3.6)  # of each chart
_DPI = 150


def save(charts: Sequence[Chart], file: BinaryIO, *, kind: str, title: str) -> None:
    """Write the figure of some charts as `png`, `pdf` or `svg`; raises OSError."""
    figure(charts, title=title).savefig(file, format=kind)


def figure(charts: Sequence[Chart], *, title: str) -> Figure:
    """Return a figure with charts below each other, in two columns if there are several."""
    across = min(len(charts), 2)
    down = -(-len(charts) // across)
    drawn = Figure((across * _SIZE_IN[0], down * _SIZE_IN[1]), dpi=_DPI, layout="constrained")
    drawn.suptitle(title)
    for at, chart in enumerate(charts):
        axes = drawn.add_subplot(down, across, at + 1)
        for line in chart.lines:
            style = ".-" if len(line.x) < 30 else "-"
            axes.plot(line.x, line.y, style, linewidth=1.0, label=line.label)
        axes.set(xlabel=chart.x_label, ylabel=chart.y_label)
        if chart.logarithmic:
            axes.set_yscale("log")
        if chart.equal:
            axes.set_aspect("equal", adjustable="datalim")
        axes.grid(visible=True, alpha=0.3)
        if len(chart.lines) > 1:
            axes.legend()
    return drawn
