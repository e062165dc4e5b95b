"""Currents in CSV: a row for each instant and level, with named columns."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from itertools import islice
from pathlib import Path

import numpy as np

from seamark.current_data.series import VALUES_MAX, Array, CurrentRefused, Series
from seamark.current_data.units import column, factor
from seamark.sim.physics.water_motion.record import FIRST_LINE, RecordInvalid, read_record

ROWS_MAX = VALUES_MAX // 5
LINE_MAX = 10_000  # characters
COMMENTS_MAX = 200
_MISSING = frozenset(("", "nan", "na", "n/a", "null", "none", "-", "--"))
_FILL = 9_000.0  # a velocity of at least so much, or of less than minus it, says nothing: -9999
_NEEDED = "time, east and north (or speed and direction), and depth or height"


def read_csv(path: Path) -> Series:
    """Return the currents of a file; raises CurrentRefused."""
    with path.open("r", encoding="utf-8-sig", errors="replace", newline="") as file:
        lines = _lines(file)
        first = next(lines, "")
        if first.strip() == FIRST_LINE:
            return _own(path)
        title = first
        for _ in range(COMMENTS_MAX):
            if not title.lstrip().startswith(("#", "%", "//")):
                break
            title = next(lines, "")
        separator = max(",;\t", key=title.count)
        columns = {}
        for at, text in enumerate(title.rstrip("\r\n").split(separator)):
            name, unit = column(text)
            if name and name not in columns:
                columns[name] = (at, unit)
        _check_columns(columns)
        rows = csv.reader(lines, delimiter=separator)
        return _series(_numbers(rows, columns), columns)


def _lines(file: Iterator[str]) -> Iterator[str]:
    for line in file:
        if len(line) > LINE_MAX:
            raise CurrentRefused(f"A line is longer than {LINE_MAX} characters.")
        if line.strip():
            yield line


def _own(path: Path) -> Series:
    """Return the currents of a record, that is read again."""
    try:
        record = read_record(path.read_bytes())
    except RecordInvalid as reason:
        raise CurrentRefused(str(reason)) from None
    times: Array = record.step_s * np.arange(record.velocity.shape[2], dtype=np.float64)
    return Series(times, record.heights, record.velocity, False, "a record of Seamark")


def _check_columns(columns: Mapping[str, tuple[int, str]]) -> None:
    vector = {"east", "north"} <= columns.keys() or {"speed", "direction"} <= columns.keys()
    if "time" not in columns or not vector:
        found = ", ".join(columns) or "none of them"
        raise CurrentRefused(f"The first line must name the columns {_NEEDED}; found: {found}.")


def _numbers(
    rows: Iterator[list[str]], columns: Mapping[str, tuple[int, str]]
) -> dict[str, list[float]]:
    """Return name -> the numbers of each row; NaN where one is missing."""
    out: dict[str, list[float]] = {name: [] for name in columns}
    try:
        for number, row in enumerate(islice(rows, ROWS_MAX + 1), 2):
            if number > ROWS_MAX:
                raise CurrentRefused(f"The file has more than {ROWS_MAX} rows.")
            for name, (at, _unit) in columns.items():
                text = row[at].strip() if at < len(row) else ""
                out[name].append(_instant(text, number) if name == "time" else _number(text))
    except csv.Error as error:
        raise CurrentRefused(f"The file is no CSV: {error}.") from None
    return out


def _number(text: str) -> float:
    if text.lower() in _MISSING:
        return math.nan
    try:
        value = float(text)
    except ValueError:
        return math.nan
    return value if abs(value) < _FILL else math.nan


def _instant(text: str, line: int) -> float:
    """Return seconds: as they stand, or since 1970 for a date."""
    try:
        value = float(text)
    except ValueError:
        try:
            moment = datetime.fromisoformat(text)
        except ValueError:
            raise CurrentRefused(
                f"Row {line}: the time must be seconds or a date as in 2026-05-01T12:00:00Z."
            ) from None
        value = (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
    if not math.isfinite(value):
        raise CurrentRefused(f"Row {line}: the time must be a finite number.")
    return value


def _series(numbers: Mapping[str, list[float]], columns: Mapping[str, tuple[int, str]]) -> Series:
    said: list[str] = []
    raw: dict[str, Array] = {name: np.array(values) for name, values in numbers.items()}
    if raw["time"].size == 0:
        raise CurrentRefused("The file has no rows.")
    _scale(raw, columns, said)
    parts = _components(raw, said)
    level, at = _level(raw, said)
    times, when = np.unique(raw["time"], return_inverse=True)
    levels, where = np.unique(at, return_inverse=True)
    if times.size * levels.size > VALUES_MAX // 3:
        raise CurrentRefused("Too many instants and levels.")
    velocity = np.full((levels.size, 3, times.size), np.nan)
    for axis, values in enumerate(parts):
        velocity[where, axis, when] = values
    return Series(times, levels, velocity, level == "depth", "CSV", said=tuple(said))


def _scale(raw: dict[str, Array], columns: Mapping[str, tuple[int, str]], said: list[str]) -> None:
    """Turn velocities into m/s."""
    without = []
    for name in ("east", "north", "up", "down", "speed"):
        if name not in raw:
            continue
        unit = columns[name][1]
        scale = factor(unit) if unit else 1.0
        if scale is None:
            raise CurrentRefused(f"The unit of {name}, {unit}, is none of a velocity.")
        if not unit:
            without.append(name)
        raw[name] = raw[name] * scale
    if without:
        said.append(f"No unit is given for {', '.join(without)}: m/s was assumed.")


def _components(raw: Mapping[str, Array], said: list[str]) -> tuple[Array, Array, Array]:
    """Return the velocity north, east and down of each row."""
    if "east" in raw and "north" in raw:
        north, east = raw["north"], raw["east"]
    else:
        to = np.deg2rad(raw["direction"])
        north, east = raw["speed"] * np.cos(to), raw["speed"] * np.sin(to)
        said.append("The direction was taken for where the water goes to, in degrees from north.")
    if "up" in raw:
        return north, east, -raw["up"]
    if "down" in raw:
        return north, east, raw["down"]
    said.append("There is no vertical velocity: it is zero.")
    return north, east, np.zeros_like(north)


def _level(raw: Mapping[str, Array], said: list[str]) -> tuple[str, Array]:
    """Return whether levels are depths or heights, and the level of each row [m]."""
    level = next((name for name in ("height", "depth") if name in raw), "")
    if not level:
        said.append("There is no depth: one level, 1 m above the bottom, was assumed.")
        return "height", np.ones_like(raw["time"])
    if not np.all(np.isfinite(raw[level])):
        raise CurrentRefused(f"A row has no {level}.")
    return level, raw[level]
