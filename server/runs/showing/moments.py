"""Moments of a trial that a viewer jumps to.

Where levels begin, largest error, losses, touches, ends of routes, and stages.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.server.runs.data.downsampling import BLOCK_ROWS
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing.views import RunView
from seamark.sim import registry
from seamark.sim.metrics.following import COMPLETED_M, REACH_M
from seamark.sim.recording.telemetry import (
    DOCK_INDEX,
    INDEX,
    ROUTE_COLUMNS,
    ROUTE_INDEX,
    SEARCH_INDEX,
    Rows,
    has_detections,
    has_dock,
    has_route,
    has_search,
)

Flags = NDArray[np.bool_]
_SAME_TIME_S = 1e-6
LOSSES_MAX = 200  # listed, the earliest ones


@dataclass(slots=True)
class _Moments:
    levels: list[dict[str, Any]] = field(default_factory=list)
    losses: list[float] = field(default_factory=list)
    touches: list[float] = field(default_factory=list)
    completed: list[float] = field(default_factory=list)
    error: float = -np.inf
    error_t: float | None = None
    level: float = np.nan  # of the row before
    lost: bool = False  # in the row before
    done: bool = False  # likewise, with the route
    touched: bool = False  # in the level of the row before

    def add(self, rows: Rows, column: int | None) -> None:
        t, level = rows[:, INDEX["t"]], rows[:, INDEX["level"]]
        begins = np.diff(level, prepend=self.level) != 0  # also of the first row: NaN
        self.levels += [{"level": int(level[at]), "t": t[at]} for at in np.flatnonzero(begins)]
        lost = _lost(rows)
        room = LOSSES_MAX - len(self.losses)
        self.losses += t[_starts(lost, self.lost, begins)][:room].tolist()
        done = _done(rows)
        self.completed += t[_starts(done, self.done, begins)].tolist()
        self._add_touches(t, begins, rows[:, INDEX["contact_n"]] > 0.0)
        if column is not None:
            self._add_error(t, np.nan_to_num(rows[:, column], nan=-np.inf))
        self.level, self.lost, self.done = float(level[-1]), bool(lost[-1]), bool(done[-1])

    def _add_error(self, t: Rows, error: Rows) -> None:
        at = int(error.argmax())
        if error[at] > self.error:
            self.error, self.error_t = float(error[at]), float(t[at])

    def _add_touches(self, t: Rows, begins: Flags, touching: Flags) -> None:
        """Note the first touch of each level; level 0 here is the one that goes on."""
        level = np.cumsum(begins)
        touches = np.flatnonzero(touching)
        touched, first = np.unique(level[touches], return_index=True)
        is_new = (touched > 0) | (not self.touched)
        self.touches += t[touches[first[is_new]]].tolist()
        goes_on = self.touched and not begins.any()
        self.touched = goes_on or bool((touched == level[-1]).any())


def _starts(holds: Flags, held: bool, begins: Flags) -> Flags:
    """Return in which rows something begins to hold, in each level anew."""
    before = np.concatenate([[held], holds[:-1]]) & ~begins
    starts: Flags = holds & ~before
    return starts


def _done(rows: Rows) -> Flags:
    """Return in which rows a route has been followed to its end."""
    if not has_route(rows.shape[1]):
        return np.zeros(len(rows), bool)
    left = rows[:, ROUTE_INDEX["route_length"]] - rows[:, ROUTE_INDEX["route_along"]]
    done: Flags = left <= COMPLETED_M
    return done


def _lost(rows: Rows) -> Flags:
    """Return in which rows the tracker has lost its target, or the vehicle its route."""
    if has_route(rows.shape[1]):
        away: Flags = rows[:, ROUTE_INDEX["cross_track"]] > REACH_M
        return away
    reported = rows[:, INDEX["tracker_ok"]]
    # A log may be without a tracker, and what a detector sees is none.
    lost: Flags = np.isfinite(reported) & (reported != 1.0) & (not has_detections(rows.shape[1]))
    if has_search(rows.shape[1]):  # what is still looked for is not lost
        lost &= rows[:, SEARCH_INDEX["searching"]] != 1.0
    elif has_dock(rows.shape[1]):
        lost &= rows[:, DOCK_INDEX["searching"]] != 1.0
    return lost


Reached = Callable[[Rows], tuple[int, ...]]  # of the rows of a level: those that reached stages


def stages_of(run: RunView) -> Reached | None:
    """Return what finds the stages of a run in the rows of a level; None without stages."""
    stages = registry.benchmark(run.benchmark).stages
    if stages is None:
        return None
    config: Any = registry.benchmark(run.benchmark).restore(run.config)
    return lambda rows: stages.reached(rows, config.control_period_s)


def moments(
    files: RunFiles, trial: int, error: str | None, reached: Reached | None = None
) -> dict[str, Any]:
    """Return the moments of a trial so far as JSON; `error` is the column whose maximum counts,
    if there is one.

    A loss is where the tracker begins to report that it has no target, in each level anew, or where
    the vehicle gets too far from the route that it follows to get on along it; a touch where the
    hull first meets the bottom or the target in a level. Where a route is followed, `completed` is
    when it was in each level.
    """
    events = _Moments()
    first, after = (files.rows_until(number, -np.inf) for number in (trial, trial + 1))
    column = files.columns.index(error) if error in files.columns else None
    for start in range(first, after, BLOCK_ROWS):
        events.add(files.rows(start, min(start + BLOCK_ROWS, after)), column)
    largest = {"column": error, "t": events.error_t, "value": events.error}
    found: dict[str, Any] = {
        "levels": events.levels,
        "largest_error": largest if events.error_t is not None else None,
        "losses": events.losses,
        "touches": events.touches,
    }
    if ROUTE_COLUMNS[0].name in files.columns:
        found["completed"] = events.completed
    if reached is None:
        return found
    starts = [files.rows_until(trial, level["t"] - _SAME_TIME_S) for level in events.levels]
    return found | {"stages": list(_stages(files, [*starts, after], reached))}


def _stages(files: RunFiles, bounds: list[int], reached: Reached) -> Iterator[dict[str, Any]]:
    """Yield level, number and time of each stage that was reached, given where levels begin."""
    for start, end in pairwise(bounds):
        rows = files.rows(start, end)
        for stage, at in enumerate(reached(rows)):
            level, t = rows[at, INDEX["level"]], rows[at, INDEX["t"]]
            yield {"level": int(level), "stage": stage, "t": float(t)}
