"""Charts of what was measured and what the fitted vehicle predicts."""

from __future__ import annotations

import numpy as np

from seamark.identification.identified import Identified
from seamark.identification.series import CHANNELS, VELOCITIES, Series
from seamark.plots.charts import Chart, Line

_POINTS = 3000  # of a line


def charts(series: Series, found: Identified) -> list[Chart]:
    """Return a chart for each velocity that was measured."""
    made = []
    for name in VELOCITIES:
        if not series.has(name):
            continue
        at = CHANNELS.index(name)
        measured, predicted = series.measured[:, at], found.predicted[:, at]
        read = np.flatnonzero(np.isfinite(measured) & np.isfinite(predicted))
        shown = read[:: max(len(read) // _POINTS, 1)]
        unit = "m/s" if name in "uvw" else "rad/s"
        made.append(
            Chart(
                title=name,
                x_label="time [s]",
                y_label=f"{name} [{unit}]",
                lines=(
                    Line("measured", series.t[shown].tolist(), measured[shown].tolist()),
                    Line("predicted", series.t[shown].tolist(), predicted[shown].tolist()),
                ),
            )
        )
    return made
