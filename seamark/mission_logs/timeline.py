"""The time of a log: in order, without gaps, at regular intervals; nothing is made up silently."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from seamark.mission_logs.mapping import CORNERS, TRUE_CORNERS, Time
from seamark.mission_logs.result import LogRefused
from seamark.mission_logs.samples import ROWS_MAX, Samples, Values

PERIOD_MIN_S, PERIOD_MAX_S = 0.01, 0.5  # of a benchmark's control period
JITTER = 0.5  # of a period: an interval that differs by more is a gap
_LATE_S = 1e6  # [s] from here on, as since 1970, a float tells microseconds only
_PERIOD_DIGITS, _PERIOD_DIGITS_LATE = 9, 6  # of the period [s]
_STAMP_DIGITS = 9
# A target out of view has no corners; and derived numbers may be undefined.
MAY_BE_NAN = frozenset(
    (*CORNERS, *TRUE_CORNERS, "tracked_x", "tracked_y", "target_x", "target_y", "tracker_error")
) | {"error_x_px", "error_y_px", "distance_px", "error_x", "error_y", "error_z"}


@dataclass(frozen=True, kw_only=True)
class Timeline:
    """The values of a log at its control steps."""

    t: Values  # [s] from the first step
    period_s: float
    values: Mapping[str, Values]
    resampled: bool


def timeline(parts: Sequence[Samples], time: Time) -> Timeline:
    """Return the values of all parts at the control steps.

    The first part says when the steps are, unless the mapping has a period.

    Raises
    ------
    LogRefused
        The order is wrong, there is a gap, a number is missing; names the line or message.
    """
    for part in parts:
        _check_values(part)
    if any("trial" in part.values for part in parts):
        return _of_trials(parts[0])
    for part in parts:
        check_order(part)
    if time.period_s is not None:
        return _held(parts, _grid(parts, time.period_s), time, time.period_s)
    first, *others = parts
    period_s = _period(first.stamps, first)
    if all(np.array_equal(first.stamps, other.stamps) for other in others):
        values = {name: column for part in parts for name, column in part.values.items()}
        t = first.stamps - first.stamps[0]
        return Timeline(t=t, period_s=period_s, values=values, resampled=False)
    return _held(parts, first.stamps, time, period_s)


def _check_values(part: Samples) -> None:
    for name, column in {"t": part.stamps, **part.values}.items():
        wrong = np.isinf(column) if name in MAY_BE_NAN else ~np.isfinite(column)
        if wrong.any():
            at = int(wrong.argmax())
            what = "infinite" if math.isinf(column[at]) else "missing or nan"
            raise LogRefused(f"{part.named(at).capitalize()}: {name} is {what}.")


def check_order(part: Samples) -> None:
    """Raise LogRefused unless each sample is later than the one before it."""
    backwards = np.diff(part.stamps) <= 0.0
    if backwards.any():
        at = int(backwards.argmax()) + 1
        raise LogRefused(
            f"{part.named(at).capitalize()} of {part.label} is not later than the one before it "
            f"({part.stamps[at]:.6f} s after {part.stamps[at - 1]:.6f} s). Sort the log by time."
        )


def _period(stamps: Values, part: Samples) -> float:
    """Return the interval of a log, which must be the same everywhere but for some jitter."""
    if len(stamps) < 2:
        raise LogRefused(f"{part.label.capitalize()} has a single {part.noun}: no time passes.")
    steps = np.diff(stamps)
    digits = _PERIOD_DIGITS if abs(stamps[-1]) < _LATE_S else _PERIOD_DIGITS_LATE
    period_s = round(float(np.median(steps)), digits)
    if not PERIOD_MIN_S <= period_s <= PERIOD_MAX_S:
        raise LogRefused(
            f"The usual interval is {period_s:g} s; the metrics take {PERIOD_MIN_S:g} to "
            f"{PERIOD_MAX_S:g} s. If the unit of the time is right, set period_s below [time]."
        )
    off = np.abs(steps - period_s) > JITTER * period_s
    if off.any():
        at = int(off.argmax())
        raise LogRefused(
            f"Between {part.named(at)} and {part.named(at + 1)} of {part.label} {steps[at]:g} s "
            f"pass instead of {period_s:g} s. To fill gaps with the values before them, set "
            "period_s and max_gap_s below [time]."
        )
    return period_s


def _of_trials(part: Samples) -> Timeline:
    """Return the rows of Seamark's own telemetry, whose time starts again with each trial."""
    trials = part.values["trial"]
    if np.any(np.diff(trials) < 0.0):
        at = int((np.diff(trials) < 0.0).argmax()) + 1
        raise LogRefused(f"{part.named(at).capitalize()}: trials are not in order.")
    starts = [0, *(np.flatnonzero(np.diff(trials)) + 1).tolist(), len(trials)]
    period_s = 0.0
    for first, after in pairwise(starts):
        piece = Samples(
            label=part.label,
            noun=part.noun,
            stamps=part.stamps[first:after],
            numbers=part.numbers[first:after],
            values={},
        )
        check_order(piece)
        own_period_s = _period(piece.stamps, piece)
        if period_s and own_period_s != period_s:
            raise LogRefused(
                f"The trials have different intervals: {period_s:g} and {own_period_s:g} s."
            )
        period_s = own_period_s
    return Timeline(t=part.stamps, period_s=period_s, values=part.values, resampled=False)


def _grid(parts: Sequence[Samples], period_s: float) -> Values:
    """Return regular control steps over the time of the first part."""
    begin, end = float(parts[0].stamps[0]), float(parts[0].stamps[-1])
    steps = (end - begin) / period_s + 1e-6
    if not steps < ROWS_MAX:
        raise LogRefused(
            f"With {period_s:g} s the log has {steps:.6g} control steps; it may have {ROWS_MAX}."
        )
    count = int(steps) + 1
    if count < 2:
        raise LogRefused(f"The log is shorter than two control steps of {period_s:g} s.")
    return begin + np.arange(count, dtype=np.float64) * np.float64(period_s)


def _held(parts: Sequence[Samples], stamps: Values, time: Time, period_s: float) -> Timeline:
    """Return each part's newest values that are not older than allowed."""
    if time.max_gap_s is None:
        names = " and ".join(part.label for part in parts[:2])
        raise LogRefused(
            f"The values of {names} are not of the same moments. To take the newest ones before "
            "each control step, set max_gap_s below [time]: how old they may be."
        )
    values: dict[str, Values] = {}
    for part in parts:
        newest, stale = _newest(part.stamps, stamps, time.max_gap_s)
        for name, column in part.values.items():
            held = column[newest]
            if name in MAY_BE_NAN:
                held = np.where(stale, np.nan, held)
            elif stale.any():
                _refuse_gap(part, stamps, stale, newest, time.max_gap_s)
            values[name] = held
    return Timeline(t=stamps - stamps[0], period_s=period_s, values=values, resampled=True)


def _newest(
    measured: Values, stamps: Values, max_gap_s: float
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the last measurement at or before each step, and whether that is too old."""
    at = np.searchsorted(measured, stamps + 10.0**-_STAMP_DIGITS, side="right") - 1
    newest = np.maximum(at, 0)
    return newest, (at < 0) | (stamps - measured[newest] > max_gap_s)


def _refuse_gap(
    part: Samples,
    stamps: Values,
    stale: NDArray[np.bool_],
    newest: NDArray[np.int64],
    max_gap_s: float,
) -> None:
    at = int(stale.argmax())
    raise LogRefused(
        f"{part.label.capitalize()} has no value within {max_gap_s:g} s before "
        f"{stamps[at] - stamps[0]:.3f} s; the last one is {part.named(int(newest[at]))}."
    )
