"""A log as the fit reads it: what drove the vehicle, what the water did, and what was measured."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from seamark.mission_logs.frames import in_telemetry_frames
from seamark.mission_logs.mapping import WRENCH, LogMapping
from seamark.mission_logs.reading import read
from seamark.mission_logs.result import LogRefused
from seamark.mission_logs.samples import Samples
from seamark.mission_logs.timeline import check_order, timeline
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.current import GUST_GRID_S, Current, Water, grid_points
from seamark.sim.physics.thrusters import pack_curve, steady_thrust
from seamark.sim.recording.telemetry import thrust_names
from seamark.sim.vehicles import Vehicle

VELOCITIES = ("u", "v", "w", "p", "q", "r")
ANGLES = ("roll", "pitch", "yaw")
CHANNELS = (*VELOCITIES, *ANGLES)
WINDOW_S = 4.0  # E: several times as long as a small vehicle takes to forget its speed
_SHORTEST_S = 1.0  # of a window
ROWS_MAX = 100_000  # an hour at 20 Hz; a fit simulates the log some 300 times
SECONDS_MAX = 4 * 3600.0
PERIOD_MAX_S = 0.5  # [s] thrust changes within less
_FORGOTTEN_LAGS = 15.0  # of the thrusters, until the unknown thrust before a log is forgotten
_GAP = 3.0  # usual intervals without a row: the log is cut there
_HELD_SHARE = 1.0 / 3.0  # of readings that repeat the one before: the log holds old values
_APART_S = 1.0  # between pieces, on the clock of the fit
_CALM = 1e-6  # [m/s] below it a current has no direction
_MARKS = ("trial", "level")  # the vehicle is put back where they change
# Beside thrusts and commands, what must have a number in every row.
_NEEDED = frozenset(("t", *_MARKS, *WRENCH, "current_x", "current_y", "contact_n"))


@dataclass(frozen=True, kw_only=True)
class Series:
    """A log of n rows, cut into windows.

    `windows` are first rows and the rows after the last, (w, 2). `measured` is (n, 9), by CHANNELS,
    nan where nothing was measured. `thrust` and `target` are (n, k) [N]: at each row, and what it
    tends to until the next one, exponentially with the vehicle's lag. `allocation` is (6, k).
    """

    t: Array
    windows: NDArray[np.int64]
    measured: Array
    thrust: Array
    target: Array
    allocation: Array
    water: Water
    driven_by: str
    notes: tuple[str, ...]

    def part(self, windows: slice) -> Series:
        """Return the same log with some of its windows."""
        return replace(self, windows=self.windows[windows])

    def has(self, channel: str) -> bool:
        """Return whether a channel was measured anywhere."""
        return bool(np.isfinite(self.measured[:, CHANNELS.index(channel)]).any())


def read_series(path: Path, mapping: LogMapping, vehicle: Vehicle) -> Series:
    """Return a log as the fit reads it.

    Raises
    ------
    LogRefused
        The log cannot be read, or not for this purpose; the text says where and what to do.
    """
    parts, guessed = read(path, mapping)
    frame = mapping.frame or guessed.frame or "NED"
    if len(parts) > 1:
        merged = timeline(parts, mapping.time)
        count = np.arange(1, len(merged.t) + 1)
        one = Samples(
            label="the log", noun="step", stamps=merged.t, numbers=count, values=merged.values
        )
    else:
        (one,) = parts
    return series_of(replace(one, values=in_telemetry_frames(one.values, frame)), vehicle)


def series_of(log: Samples, vehicle: Vehicle) -> Series:
    """Return samples in the frames of the telemetry as the fit reads them; raises LogRefused."""
    _check_values(log)
    pieces = _pieces(log)
    measured, notes = _measured(log)
    t = _clock(log.stamps, pieces)
    driven_by, thrust, target = _driven(log, vehicle, pieces)
    whole = driven_by == "the wrench"
    waited_s = _FORGOTTEN_LAGS * vehicle.lag.scalar if driven_by == "commands" else 0.0
    windows = _windows(t, pieces, _touches(log), waited_s)
    if not len(windows):
        raise LogRefused(
            f"The log has no stretch of {_SHORTEST_S:g} s without a gap or a contact, so nothing "
            "can be fitted."
        )
    if not {"roll", "pitch"} <= log.values.keys():
        notes.append("The log has no roll and pitch: each window is taken to begin level.")
    return Series(
        t=t,
        windows=windows,
        measured=measured,
        thrust=thrust,
        target=target,
        allocation=np.eye(6) if whole else vehicle.allocation(),
        water=_water(log, t, notes),
        driven_by=driven_by,
        notes=tuple(notes),
    )


def _check_values(log: Samples) -> None:
    if len(log.stamps) > ROWS_MAX:
        raise LogRefused(
            f"The log has {len(log.stamps)} rows; a fit takes {ROWS_MAX}. Cut it, or thin it out "
            "to 20 rows a second."
        )
    for name, column in {"t": log.stamps, **log.values}.items():
        if name in CHANNELS:
            wrong = np.isinf(column)
        elif name in _NEEDED or name.startswith(("thrust_", "command_")):
            wrong = ~np.isfinite(column)
        else:
            continue
        if wrong.any():
            at = int(wrong.argmax())
            what = "infinite" if math.isinf(column[at]) else "missing or nan"
            raise LogRefused(
                f"{log.named(at).capitalize()}: {name} is {what}. Leave the row out; only "
                "measured velocities and angles may be empty, where there was no reading."
            )


def _pieces(log: Samples) -> list[tuple[int, int]]:
    """Return the first row of each stretch without a gap, and the row after it."""
    steps = np.diff(log.stamps)
    cuts = np.zeros(len(steps), dtype=bool)
    for name in _MARKS:
        if name in log.values:
            cuts |= np.diff(log.values[name]) != 0.0
    edges = [0, *(np.flatnonzero(cuts) + 1).tolist(), len(log.stamps)]
    for first, after in pairwise(edges):
        check_order(replace(log, stamps=log.stamps[first:after], numbers=log.numbers[first:after]))
    if not (~cuts).any():
        raise LogRefused("The log has a single row: no time passes.")
    period_s = float(np.median(steps[~cuts]))
    if period_s > PERIOD_MAX_S:
        raise LogRefused(
            f"The usual interval of the log is {period_s:g} s; a fit needs {PERIOD_MAX_S:g} s or "
            "less. If the log is dense enough, its time is in another unit: say so in the mapping."
        )
    cuts |= steps > _GAP * period_s
    edges = [0, *(np.flatnonzero(cuts) + 1).tolist(), len(log.stamps)]
    return list(pairwise(edges))


def _clock(stamps: Array, pieces: Sequence[tuple[int, int]]) -> Array:
    """Return times on one clock [s], on which pieces follow each other."""
    t, begin = np.empty(len(stamps)), 0.0
    for first, after in pieces:
        t[first:after] = begin + stamps[first:after] - stamps[first]
        begin = float(t[after - 1]) + _APART_S
    if t[-1] > SECONDS_MAX:
        raise LogRefused(f"The log is longer than {SECONDS_MAX:g} s. Cut it into parts.")
    return t


def _touches(log: Samples) -> NDArray[np.bool_]:
    contact = log.values.get("contact_n")
    if contact is None:
        return np.zeros(len(log.stamps), dtype=bool)
    return contact > 0.0


def _windows(
    t: Array, pieces: Sequence[tuple[int, int]], touches: NDArray[np.bool_], waited_s: float
) -> NDArray[np.int64]:
    """Return the windows of all pieces, (w, 2); one with a contact is left out.

    The first begins so long after the piece, when the thrust before it no longer matters.
    """
    windows = []
    for first, after in pieces:
        at = first + int(np.searchsorted(t[first:after], t[first] + waited_s))
        while at < after:
            end = int(np.searchsorted(t[first:after], t[at] + WINDOW_S)) + first
            if t[end - 1] - t[at] >= _SHORTEST_S and not touches[at:end].any():
                windows.append((at, end))
            at = end
    return np.array(windows, dtype=np.int64).reshape(-1, 2)


def _measured(log: Samples) -> tuple[Array, list[str]]:
    """Return what was measured, (n, 9), and what is to be said about it."""
    measured, held = np.full((len(log.stamps), len(CHANNELS)), np.nan), []
    for at, name in enumerate(CHANNELS):
        if name not in log.values:
            continue
        column = log.values[name].copy()
        repeats = np.append(False, column[1:] == column[:-1])
        if 1.0 > repeats.mean() > _HELD_SHARE:
            column[repeats] = np.nan
            held.append(name)
        measured[:, at] = column
    if not np.isfinite(measured[:, : len(VELOCITIES)]).any():
        raise LogRefused(
            "The log has none of the velocities u, v, w [m/s], p, q, r [rad/s] in body axes. Name "
            'them in the mapping, such as u = "dvl_x" below [columns].'
        )
    notes = []
    if held:
        notes.append(
            f"{', '.join(held)} repeat old values until the next reading; a repeated value does "
            "not count."
        )
    return measured, notes


def _driven(
    log: Samples, vehicle: Vehicle, pieces: Sequence[tuple[int, int]]
) -> tuple[str, Array, Array]:
    """Return what drove the vehicle, the thrust at each row and its target, (n, k) [N]."""
    count = len(vehicle.thrusters)
    thrusts = thrust_names(count)
    commands = tuple(f"command_{at}" for at in range(count))
    for what, names in (
        ("thrusts", thrusts), ("commands", commands), ("the wrench", WRENCH)
    ):  # fmt: skip
        given = [name for name in names if name in log.values]
        if not given:
            continue
        if len(given) < len(names):
            missing = next(name for name in names if name not in log.values)
            raise LogRefused(
                f"The log has {given[0]} and no {missing}; {vehicle.name} has {count} thrusters, "
                "and each needs its column. The wrench needs all six of force_x to moment_z."
            )
        columns = np.stack([log.values[name] for name in names], axis=1)
        if what == "commands":
            return what, *_from_commands(columns, log, vehicle, pieces)
        return what, columns, _targets(columns, log.stamps, vehicle.lag.scalar)
    raise LogRefused(
        "The log does not say what drove the vehicle: it needs a column for each thruster, its "
        "thrust (thrust_0, ... [N]) or its command (command_0, ... from -1 to 1), or the wrench "
        "(force_x, force_y, force_z [N], moment_x, moment_y, moment_z [N m], body axes)."
    )


def _targets(thrust: Array, stamps: Array, lag_s: float) -> Array:
    """Return what the thrust tends to after each row, so that it has its value at the next."""
    target = thrust.copy()
    rest = np.exp(-np.maximum(np.diff(stamps), 1e-6) / lag_s)[:, None]
    target[:-1] = (thrust[1:] - thrust[:-1] * rest) / (1.0 - rest)
    return target


def _from_commands(
    commands: Array, log: Samples, vehicle: Vehicle, pieces: Sequence[tuple[int, int]]
) -> tuple[Array, Array]:
    """Return the thrusts of commands that hold from each row to the next, and their targets."""
    wrong = np.abs(commands) > 1.0 + 1e-9
    if wrong.any():
        row, at = (int(one[0]) for one in np.nonzero(wrong))
        raise LogRefused(
            f"{log.named(row).capitalize()}: command_{at} is {commands[row, at]:g}; commands are "
            "from -1 to 1. Of a pulse width in µs, (width - 1500) / 400 is usual."
        )
    curve, target = pack_curve(vehicle.curve), np.empty_like(commands)
    for row, own in enumerate(np.ascontiguousarray(commands)):
        steady_thrust(own, curve, target[row])
    thrust = np.empty_like(target)
    for first, after in pieces:
        thrust[first] = target[first]
        for row in range(first, after - 1):
            rest = math.exp(-(log.stamps[row + 1] - log.stamps[row]) / vehicle.lag.scalar)
            thrust[row + 1] = target[row] + (thrust[row] - target[row]) * rest
    return thrust, target


def _water(log: Samples, t: Array, notes: list[str]) -> Water:
    """Return the logged current, linear in speed and direction between points 0.05 s apart."""
    still = Current(0.0).water
    given = {"current_x", "current_y"} & log.values.keys()
    if not given:
        notes.append("The log has no current: the water is taken to be still.")
        return still
    if len(given) < 2:
        raise LogRefused("The log has one of current_x and current_y; it needs both or neither.")
    if not _moves(log.values):
        return still
    if "yaw" not in log.values:
        raise LogRefused("A log with a current needs yaw: the current is in world axes.")
    grid = GUST_GRID_S * np.arange(grid_points(float(t[-1])))
    x, y = (np.interp(grid, t, log.values[name]) for name in ("current_x", "current_y"))
    speed = np.hypot(x, y)
    moving = speed > _CALM
    angle = np.interp(grid, grid[moving], np.unwrap(np.arctan2(-y, -x)[moving]))
    return still._replace(azimuth_swing=0.0, drift=np.stack([speed, angle]))


def _moves(values: Mapping[str, Array]) -> bool:
    return bool(np.hypot(values["current_x"], values["current_y"]).max() > _CALM)
