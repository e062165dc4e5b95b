"""Reads a log from CSV: comment lines with #, the names of the columns, then numbers."""

from __future__ import annotations

import csv
import gzip
import io
from array import array
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

import numpy as np

from seamark.mission_logs.csv_values import (
    Dates,
    Number,
    is_date,
    number,
    number_with_comma,
    unit_of_time,
)
from seamark.mission_logs.guesses import Guesses, guess_columns
from seamark.mission_logs.mapping import KNOWN, LogMapping, Source, factor
from seamark.mission_logs.result import LogRefused
from seamark.mission_logs.samples import ROWS_MAX, Samples

LINE_MAX = 64 * 1024  # [character]
COMMENTS_MAX = 1000  # lines above the names
LINES_MAX = 2 * ROWS_MAX  # with comments and empty ones
COLUMNS_MAX = 1000
NAMES_SHOWN = 12
_DELIMITERS = ",;\t"
MOTION = frozenset("uvwpqr")  # columns that a log may do without


def read(path: Path, mapping: LogMapping) -> tuple[Samples, Guesses]:
    """Return the rows of a CSV file, which may be compressed with gzip, and what was guessed.

    Raises
    ------
    LogRefused
        A column is missing, a value is no number, or the file is too large; names the line.
    """
    with _opened(path) as file:
        lines = _Lines(file)
        header = lines.header()
        delimiter = _delimiter(header)
        names = _cells(header, delimiter)
        given = _given(names, mapping)
        guessed = guess_columns(names, given, mapping.frame or "NED")
        _check_time(names, {**given, **guessed})
        table = _Table(names, {**given, **guessed}, set(guessed))
        for cells in _rows(lines, delimiter):
            table.add(cells, lines.number, delimiter)
    return table.samples(), table.guesses()


@contextmanager
def _opened(path: Path) -> Iterator[TextIO]:
    with path.open("rb") as raw:
        compressed = raw.peek(2)[:2] == b"\x1f\x8b"
        binary = gzip.GzipFile(fileobj=raw) if compressed else raw
        try:
            yield io.TextIOWrapper(binary, encoding="utf-8-sig", newline="")
        except UnicodeDecodeError:
            raise LogRefused("The file is not text in UTF-8.") from None
        except (gzip.BadGzipFile, EOFError) as error:
            raise LogRefused(f"The compressed file is damaged: {error}.") from None


class _Lines:
    """The lines of a file, counted; none is longer than `LINE_MAX`."""

    def __init__(self, file: TextIO) -> None:
        self._file = file
        self.number = 0

    def __iter__(self) -> Iterator[str]:
        while line := self._file.readline(LINE_MAX + 1):
            self.number += 1
            if len(line) > LINE_MAX:
                raise LogRefused(f"Line {self.number} is longer than {LINE_MAX} characters.")
            if self.number > LINES_MAX:
                raise LogRefused(f"The file has more than {LINES_MAX} lines. Cut it into parts.")
            yield line.rstrip("\r\n")

    def header(self) -> str:
        """Return the first line that is no comment."""
        for line in self:
            if self.number > COMMENTS_MAX:
                break
            if line.strip() and not line.startswith("#"):
                return line
        raise LogRefused("The file has no line with the names of its columns.")


def _delimiter(header: str) -> str:
    return max(_DELIMITERS, key=header.count)


def _cells(line: str, delimiter: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])]
    except csv.Error:
        return []


def _given(names: Sequence[str], mapping: LogMapping) -> dict[str, Source]:
    """Return the columns that the mapping names, or that have the names of the telemetry."""
    if len(names) > COLUMNS_MAX:
        raise LogRefused(f"The file has {len(names)} columns; a log may have {COLUMNS_MAX}.")
    sources = {name: Source(name=name) for name in KNOWN if name in names}
    sources |= mapping.columns
    missing = [source.name for source in sources.values() if source.name not in names]
    if missing:
        raise LogRefused(
            f"The file has no column {missing[0]!r}, which the mapping names. It has: "
            f"{_listed(names)}."
        )
    doubled = [source.name for source in sources.values() if names.count(source.name) > 1]
    if doubled:
        raise LogRefused(f"The file has several columns {doubled[0]!r}.")
    return sources


def _check_time(names: Sequence[str], sources: Mapping[str, Source]) -> None:
    if "t" not in sources:
        raise LogRefused(
            "The file has no column t, the time in seconds. Name yours in the mapping, such as "
            f't = {{ name = "stamp", unit = "ms" }} below [columns]. It has: {_listed(names)}.'
        )


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(name[:40] for name in names[:NAMES_SHOWN])
    return shown + (" and more" if len(names) > NAMES_SHOWN else "")


def _rows(lines: _Lines, delimiter: str) -> Iterator[list[str]]:
    for line in lines:
        if line.strip() and not line.startswith("#"):
            yield _cells(line, delimiter)


class _Table:
    """The rows of a file, as they come; the first says how its numbers and times are written."""

    def __init__(
        self, names: Sequence[str], sources: Mapping[str, Source], guessed: Collection[str]
    ) -> None:
        self._at = {column: names.index(source.name) for column, source in sources.items()}
        self._sources = dict(sources)
        self._guessed = guessed
        self._columns = {name: array("d") for name in sources}
        self._line_numbers = array("q")
        self._read: dict[str, tuple[Number, float]] = {}

    def add(self, cells: Sequence[str], line: int, delimiter: str) -> None:
        """Add a row; raises LogRefused."""
        if len(self._line_numbers) == ROWS_MAX:
            raise LogRefused(f"The log has more than {ROWS_MAX} rows. Cut it into parts.")
        if not self._read:
            self._begin(_cell(cells, self._at["t"], "t", line), delimiter)
        for name, at in self._at.items():
            text = _cell(cells, at, name, line)
            read, scale = self._read[name]
            try:
                self._columns[name].append(read(text) * scale)
            except ValueError:
                time = name == "t" and isinstance(read, Dates)
                what = "a time by ISO 8601 like the first" if time else "a number"
                raise LogRefused(
                    f"Line {line}, column {name}: {text[:40]!r} is not {what}."
                ) from None
        self._line_numbers.append(line)

    def _begin(self, time: str, delimiter: str) -> None:
        """Choose how each column is read, by the first row."""
        read = number if delimiter == "," else number_with_comma
        source = self._sources["t"]
        if "t" in self._guessed and not source.unit:
            self._sources["t"] = Source(name=source.name, unit=unit_of_time(time, read))
        self._read = {name: (read, factor(name, one)) for name, one in self._sources.items()}
        if is_date(time):
            self._read["t"] = Dates(), 1.0

    def samples(self) -> Samples:
        """Return all rows; what was guessed and is not needed has to be whole."""
        if not self._line_numbers:
            raise LogRefused("The file has no rows.")
        values = {name: np.frombuffer(column) for name, column in self._columns.items()}
        for name in [name for name in values if name in self._guessed and name in MOTION]:
            if not np.isfinite(values[name]).all():
                del values[name], self._sources[name]
        return Samples(
            label="the file",
            noun="line",
            stamps=values.pop("t"),
            numbers=np.frombuffer(self._line_numbers, dtype=np.int64),
            values=values,
        )

    def guesses(self) -> Guesses:
        """Return what was guessed of the columns."""
        kept = {name: one for name, one in self._sources.items() if name in self._guessed}
        return Guesses(columns=kept)


def _cell(cells: Sequence[str], at: int, name: str, line: int) -> str:
    if at >= len(cells):
        raise LogRefused(f"Line {line} has {len(cells)} values; column {name} is number {at + 1}.")
    return cells[at]
