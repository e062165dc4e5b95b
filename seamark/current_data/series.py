"""What was read of a file of currents, before gaps are filled: and how a record is made of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.physics.water_motion.record import (
    BYTES_MAX,
    FASTEST_M_S,
    HEIGHTS_MAX,
    INSTANTS_LEAST,
    INSTANTS_MAX,
    Record,
    read_record,
    write_record,
)

Array = NDArray[np.float64]
VALUES_MAX = 20_000_000  # numbers of a file that are read
GAP_MAX = 5  # samples in a row that are filled, linearly
MISSING_MAX = 0.1  # share of a height, and of a record, that may be missing
_ROW_BYTES = 40  # of a record's file, about


class CurrentRefused(ValueError):
    """The file cannot become a record of currents. Its text is written for the user."""


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """Velocities at instants and levels, with NaN where nothing was measured."""

    times: Array  # (n,) [s] increasing
    levels: Array  # (h,) [m]
    velocity: Array  # (h, 3, n) NED [m/s]
    down: bool  # whether levels are depths below the surface, else heights above the bottom
    layout: str  # what the file was taken for
    begins: str = ""  # ISO 8601 of the first instant, if known
    said: tuple[str, ...] = field(default=())  # what was assumed or left out


class Gaps(NamedTuple):
    """What was missing, and what was done about it."""

    missing: float  # share of all numbers
    dropped: tuple[float, ...]  # [m] levels with too little
    filled: int  # samples, linearly
    cut: int  # instants at the ends, or beside a long gap


class Made(NamedTuple):
    """A record and how it was made."""

    record: Record
    gaps: Gaps
    said: tuple[str, ...]


def record_of(
    series: Series,
    *,
    bottom_m: float | None = None,
    step_s: float | None = None,
    notes: dict[str, str] | None = None,
) -> Made:
    """Return the record of a series.

    Parameters
    ----------
    bottom_m
        Depth of the bottom, for levels that are depths.
    step_s
        Between two instants; None: the series' own, or longer until the file is small enough.

    Raises
    ------
    CurrentRefused
        Too much is missing, or too little is there.
    """
    _check(series)
    said = list(series.said)
    heights, velocity = _by_height(series, bottom_m, said)
    velocity, heights, gaps, kept = _without_gaps(velocity, heights)
    times = series.times[kept]
    if times.size < INSTANTS_LEAST:
        raise CurrentRefused(
            f"Only {times.size} instants in a row have no gap longer than {GAP_MAX} samples; a "
            f"record needs {INSTANTS_LEAST}."
        )
    own = float(np.median(np.diff(times)))
    wanted = max(step_s or own, _least_step(times, heights.size))
    velocity = _resampled(times, velocity, wanted, own)
    if velocity.shape[2] < INSTANTS_LEAST:
        raise CurrentRefused(f"A step of {wanted:g} s leaves {velocity.shape[2]} instants.")
    if wanted > own:
        said.append(f"Means over {wanted:g} s were taken of samples every {own:g} s.")
    record = Record(wanted, heights, velocity, dict(notes or {}))
    content = write_record(record)
    return Made(read_record(content), gaps, tuple(said))


def _check(series: Series) -> None:
    if series.times.size < INSTANTS_LEAST:
        raise CurrentRefused(f"The file has {series.times.size} instants: too few.")
    if np.any(np.diff(series.times) <= 0.0):
        raise CurrentRefused("The instants of the file do not increase.")
    finite = series.velocity[np.isfinite(series.velocity)]
    if finite.size == 0:
        raise CurrentRefused("The file has no velocity that is a number.")
    fastest = float(np.abs(finite).max())
    if fastest > FASTEST_M_S:
        raise CurrentRefused(
            f"The fastest velocity would be {fastest:g} m/s. Say the unit in the file: as the "
            "attribute `units`, or after the name of a column, as in east_cm_s."
        )


def _by_height(series: Series, bottom_m: float | None, said: list[str]) -> tuple[Array, Array]:
    """Return heights above the bottom, increasing, and velocities in that order."""
    heights = series.levels
    if series.down:
        deepest = float(series.levels.max())
        if bottom_m is None:
            spacing = float(np.median(np.abs(np.diff(series.levels)))) if heights.size > 1 else 1.0
            bottom_m = deepest + spacing
            said.append(
                f"The bottom was taken to be {bottom_m:g} m deep, one spacing below the deepest "
                "level: --bottom says it."
            )
        if bottom_m < deepest:
            raise CurrentRefused(f"The deepest level, {deepest:g} m, lies below the bottom.")
        heights = bottom_m - series.levels
    order = np.argsort(heights, kind="stable")
    if np.any(np.diff(heights[order]) <= 0.0) or heights[order[0]] < 0.0:
        raise CurrentRefused("The levels of the file must differ and lie above the bottom.")
    return heights[order], series.velocity[order]


def _without_gaps(velocity: Array, heights: Array) -> tuple[Array, Array, Gaps, NDArray[np.int64]]:
    """Return filled velocities, their heights, what was done, and the instants that are left."""
    lost: NDArray[np.bool_] = np.isnan(velocity.sum(axis=1))  # (h, n)
    missing = float(lost.mean())
    enough = lost.mean(axis=1) <= MISSING_MAX
    if not enough.any():
        raise CurrentRefused(
            f"At every level more than {MISSING_MAX:.0%} of the samples are missing, "
            f"{missing:.0%} of all."
        )
    kept, gone = velocity[enough], lost[enough]
    broken: NDArray[np.bool_] = np.array([_long_gaps(row) for row in gone])
    first, last = _longest(np.logical_or.reduce(broken, axis=0))
    kept, gone = kept[:, :, first:last].copy(), gone[:, first:last]
    at = np.arange(last - first)
    for level, row in zip(kept, gone, strict=True):
        for axis in range(3):
            level[axis, row] = np.interp(at[row], at[~row], level[axis, ~row])
    if heights[enough].size > HEIGHTS_MAX:
        raise CurrentRefused(f"A record has at most {HEIGHTS_MAX} levels.")
    gaps = Gaps(
        missing, tuple(heights[~enough].tolist()), int(gone.sum()), lost.shape[1] - (last - first)
    )
    return kept, heights[enough], gaps, np.arange(first, last)


def _long_gaps(lost: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return where a gap is that is too long to fill, or has an end of the series."""
    out = np.zeros_like(lost)
    for first, last in _runs(lost):
        if last - first > GAP_MAX or first == 0 or last == lost.size:
            out[first:last] = True
    return out


def _runs(mask: NDArray[np.bool_]) -> Sequence[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _longest(broken: NDArray[np.bool_]) -> tuple[int, int]:
    return max(_runs(~broken), key=lambda run: run[1] - run[0], default=(0, 0))


def _least_step(times: Array, heights: int) -> float:
    """Return the shortest step [s] at which a record's file is small enough."""
    most = min(INSTANTS_MAX, BYTES_MAX // (_ROW_BYTES * heights))
    return float(times[-1] - times[0]) / (most - 1)


def _resampled(times: Array, velocity: Array, step_s: float, own_s: float) -> Array:
    """Return velocities at equal steps: means over longer ones, else linear between samples."""
    count = int((times[-1] - times[0]) / step_s + 1e-6) + 1
    grid = times[0] + step_s * np.arange(count)
    rows = velocity.reshape(-1, times.size)
    if step_s <= 1.5 * own_s:
        out = np.array([np.interp(grid, times, row) for row in rows])
    else:
        # The integral at the edges of each step, by the trapezoidal rule, over its length.
        edges = np.clip(np.append(grid, grid[-1] + step_s) - 0.5 * step_s, times[0], times[-1])
        steps = np.diff(times)
        sums = [
            np.concatenate([[0.0], np.cumsum(0.5 * (row[1:] + row[:-1]) * steps)]) for row in rows
        ]
        out = np.array([np.diff(np.interp(edges, times, total)) / np.diff(edges) for total in sums])
    return out.reshape(velocity.shape[0], 3, count)


def cut(series: Series, *, first_s: float, length_s: float | None) -> Series:
    """Return a part of a series, from so long after its beginning on."""
    since = series.times - series.times[0]
    last_s = np.inf if length_s is None else first_s + length_s
    chosen = (since >= first_s) & (since <= last_s)
    return replace(series, times=series.times[chosen], velocity=series.velocity[:, :, chosen])
