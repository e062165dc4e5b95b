"""Telemetry of a trial or a level on an axis that several runs share, for overlaid charts."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from seamark.server.runs.data.downsampling import extremes_of_rows
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing.views import RunView
from seamark.sim import registry
from seamark.sim.recording.telemetry import INDEX

Rows = NDArray[np.float64]
_DIGITS = 6  # [decimal places of a second]: times of equal steps are equal


@dataclass(frozen=True, slots=True)
class Series:
    """Columns of one run, thinned.

    Attributes
    ----------
    start_s : [s]
        Simulated time in the trial at which `t` is 0; None if the run has not been there.
    t : (n,) [s]
        Since the start of the trial, or of the level.
    values : (n, columns)
        nan where there is no value.
    """

    start_s: float | None
    t: Rows
    values: Rows


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """The part of a run that is shown: a trial, or one of its levels."""

    trial: int = 0
    level: int | None = None  # by its index, whatever the order in which the levels ran


def series(
    view: RunView, files: RunFiles, columns: Sequence[str], part: Part, max_points: int
) -> Series:
    """Return columns of a part of a run, at most `max_points` with the peaks kept.

    Runs whose levels ran in different orders are compared by the level, since its start.
    """
    first, after = _rows_of(view, files, part)
    if after <= first:
        return Series(None, np.empty(0), np.empty((0, len(columns))))
    start_s = float(files.rows(first, first + 1)[0, INDEX["t"]]) if part.level is not None else 0.0
    index = {name: at for at, name in enumerate(files.columns)}
    wanted = [index[name] for name in columns]
    t, values = extremes_of_rows(files, (first, after), wanted, max_points)
    return Series(start_s, np.round(t - start_s, _DIGITS), values)


def _rows_of(view: RunView, files: RunFiles, part: Part) -> tuple[int, int]:
    """Return the first row and the one after the last; an empty range if there are none."""
    first, after = files.rows_until(part.trial, -np.inf), files.rows_until(part.trial + 1, -np.inf)
    if part.level is None:
        return first, after
    config = registry.benchmark(view.benchmark).restore(view.config)
    count = len(config.level_values())
    edges = np.linspace(0.0, config.trial_duration_s(), count + 1)
    for start, stop in pairwise(edges.tolist()):
        middle = files.rows_until(part.trial, 0.5 * (start + stop))
        row = files.rows(middle - 1, middle) if middle > first else files.rows(0, 0)
        if len(row) and row[0, INDEX["t"]] >= start and row[0, INDEX["level"]] == part.level:
            return _level_around(files, middle - 1, (first, after), part.level)
    return first, first


def _level_around(
    files: RunFiles, at: int, between: tuple[int, int], level: int
) -> tuple[int, int]:
    """Return the range of rows of a level around row `at` of a trial, by bisection."""

    def is_in(row: int) -> bool:
        return bool(files.rows(row, row + 1)[0, INDEX["level"]] == level)

    low, high = between[0] - 1, at  # `high` is in the level, `low` is not
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if is_in(middle) else (middle, high)
    first = high
    low, high = at, between[1]
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if is_in(middle) else (low, middle)
    return first, high
