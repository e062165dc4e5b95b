"""Thinning of telemetry for charts: the peaks of each interval stay."""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from seamark.server.runs.data.files import RunFiles
from seamark.sim.recording.telemetry import INDEX

BLOCK_ROWS = 16_384  # read at once, so that a long trial takes no more memory than a short one
Rows = NDArray[np.float64]


def extremes_of_rows(
    files: RunFiles, between: tuple[int, int], columns: list[int], points: int
) -> tuple[Rows, Rows]:
    """Return times and columns of a range of rows, downsampled block by block.

    Parameters
    ----------
    between
        The first row and the one after the last.
    columns
        Their positions in a row.
    """
    first, after = between
    blocks = max(math.ceil((after - first) / BLOCK_ROWS), 1)
    parts = []
    for start, stop in pairwise(np.linspace(first, after, blocks + 1).astype(int).tolist()):
        rows = files.rows(start, stop)
        parts.append(downsample(rows[:, INDEX["t"]], rows[:, columns], max(points // blocks, 2)))
    return np.concatenate([t for t, _ in parts]), np.concatenate([values for _, values in parts])


def downsample(t: Rows, columns: Rows, max_points: int) -> tuple[Rows, Rows]:
    """Return at most `max_points` points: the two extremes of each interval, in their order.

    Parameters
    ----------
    t : (n,) [s]
    columns : (n, k)
    max_points
        At least 2.

    Returns
    -------
    t : (m,) [s], columns : (m, k)
        The rows themselves if there are no more than `max_points`.
    """
    if len(t) <= max_points:
        return t, columns
    edges = np.linspace(0, len(t), max_points // 2 + 1).astype(int)
    times: list[float] = []
    values: list[Rows] = []
    for start, stop in pairwise(edges):
        interval = columns[start:stop]
        times += [t[start], t[stop - 1]]
        values += _extremes(interval)
    return np.array(times), np.array(values)


def _extremes(interval: Rows) -> tuple[Rows, Rows]:
    """Return two rows: minimum and maximum of each column, in the order of their occurrence."""
    # NaN would win every comparison; it stays only where there is nothing else.
    low = np.where(np.isnan(interval), np.inf, interval).argmin(axis=0)
    high = np.where(np.isnan(interval), -np.inf, interval).argmax(axis=0)
    every = np.arange(interval.shape[1])
    return interval[np.minimum(low, high), every], interval[np.maximum(low, high), every]
