"""Reads a log from CSV: comment lines with #, the names of the columns, then numbers."""

from __future__ import annotations

import csv
import gzip
import io
import math
from array import array
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

import numpy as np

from seamark.mission_logs.mapping import KNOWN, LogMapping, Source, factor
from seamark.mission_logs.refusal import LogRefused
from seamark.mission_logs.samples import ROWS_MAX, Samples

LINE_MAX = 64 * 1024  # [character]
COMMENTS_MAX = 1000  # lines above the names
LINES_MAX = 2 * ROWS_MAX  # with comments and empty ones
COLUMNS_MAX = 1000
NAMES_SHOWN = 12
_DELIMITERS = ",;\t"
_EMPTY = frozenset({"", "nan", "NaN", "NAN", "null", "None"})


def read(path: Path, mapping: LogMapping) -> Samples:
    """Return the rows of a CSV file, which may be compressed with gzip.

    Raises
    ------
    LogRefused
        A column is missing, a value is no number, or the file is too large; names the line.
    """
    with _opened(path) as file:
        lines = _Lines(file)
        header = lines.header()
        names = _cells(header, _delimiter(header))
        chosen = _chosen(names, mapping)
        return _samples(lines, _delimiter(header), chosen)


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


def _chosen(names: Sequence[str], mapping: LogMapping) -> dict[str, tuple[int, float]]:
    """Return for each column of the telemetry where it is in a line, and its factor."""
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
    if "t" not in sources:
        raise LogRefused(
            "The file has no column t, the time in seconds. Name yours in the mapping, such as "
            f't = {{ name = "stamp", unit = "ms" }} below [columns]. It has: {_listed(names)}.'
        )
    doubled = [source.name for source in sources.values() if names.count(source.name) > 1]
    if doubled:
        raise LogRefused(f"The file has several columns {doubled[0]!r}.")
    return {
        column: (names.index(source.name), factor(column, source))
        for column, source in sources.items()
    }


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(name[:40] for name in names[:NAMES_SHOWN])
    return shown + (" and more" if len(names) > NAMES_SHOWN else "")


def _samples(lines: _Lines, delimiter: str, chosen: dict[str, tuple[int, float]]) -> Samples:
    columns = {name: array("d") for name in chosen}
    places = array("q")
    for line in lines:
        if not line.strip() or line.startswith("#"):
            continue
        if len(places) == ROWS_MAX:
            raise LogRefused(f"The log has more than {ROWS_MAX} rows. Cut it into parts.")
        cells = _cells(line, delimiter)
        for name, (at, scale) in chosen.items():
            columns[name].append(_number(cells, at, name, lines.number) * scale)
        places.append(lines.number)
    if not places:
        raise LogRefused("The file has no rows.")
    values = {name: np.frombuffer(column) for name, column in columns.items()}
    return Samples(
        label="the file",
        noun="line",
        stamps=values.pop("t"),
        places=np.frombuffer(places, dtype=np.int64),
        values=values,
    )


def _number(cells: Sequence[str], at: int, name: str, line: int) -> float:
    if at >= len(cells):
        raise LogRefused(f"Line {line} has {len(cells)} values; column {name} is number {at + 1}.")
    text = cells[at]
    if text in _EMPTY:
        return math.nan
    try:
        return float(text)
    except ValueError:
        raise LogRefused(f"Line {line}, column {name}: {text[:40]!r} is not a number.") from None
