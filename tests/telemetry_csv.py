"""Reads the telemetry that the product writes as CSV."""

import numpy as np

from seamark.sim.recording.telemetry import Rows


def read(text: str) -> tuple[list[str], Rows]:
    """Return the column names and the rows, (k, number of columns), of a CSV document."""
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    names = lines[0].split(",")
    values = [list(map(float, line.split(","))) for line in lines[1:]]
    return names, np.array(values).reshape(len(values), len(names))
