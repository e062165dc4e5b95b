"""A small curve of the error of a run, stored with its result: lists draw it without its files."""

import math

import numpy as np

from seamark.server.runs.data.files import RunFiles
from seamark.sim import registry
from seamark.sim.recording.telemetry import COLUMNS, ROUTE_COLUMNS

POINTS = 32
ROWS_PER_POINT = 8
_DIGITS = 3

UNITS = {column.name: column.unit for column in (*COLUMNS, *ROUTE_COLUMNS)}
Curve = list[float | None]


def error_column(benchmark: str) -> str | None:
    """Return the column of the error that a benchmark is about; None if no single one says it."""
    return registry.benchmark(benchmark).error_column


def error_curve(files: RunFiles, benchmark: str) -> Curve | None:
    """Return the mean error in equal parts of the first trial; None without any rows or column.

    In m or px, as the column; None where the rows have no value. A few rows of each part are read,
    so a long run costs as much as a short one.
    """
    column, rows = error_column(benchmark), files.rows_until(0, math.inf)
    if column is None or rows == 0:
        return None
    count = min(POINTS * ROWS_PER_POINT, rows)
    picked = np.linspace(0, rows - 1, count).astype(int).tolist()
    values = files.rows_at(picked)[:, files.columns.index(column)]
    return [_mean(part) for part in np.array_split(values, min(POINTS, len(values)))]


def _mean(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> float | None:
    finite = values[np.isfinite(values)]
    return float(f"{finite.mean():.{_DIGITS}g}") if len(finite) else None
