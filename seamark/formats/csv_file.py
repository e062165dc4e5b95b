"""CSV: every number as the shortest text that reads back as the same float."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import BinaryIO

import numpy as np

from seamark.formats.recording import BLOCK_ROWS, Recording
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import Rows

WRITTEN_ROWS = BLOCK_ROWS // 10  # of text at a time: 1 MB
COMMENTS_MAX = 1000  # lines above the names
_COMMENT = "#"


class NotTelemetry(ValueError):
    """The text is not a table of telemetry."""


def write(recording: Recording, file: BinaryIO) -> None:
    """Write comments, the names of the columns, and all rows."""
    for piece in pieces(recording):
        file.write(piece)


def pieces(recording: Recording) -> Iterator[bytes]:
    """Yield the file in pieces."""
    yield telemetry.header(recording.comments, width=recording.width).encode()
    for rows in recording.blocks(WRITTEN_ROWS):
        yield telemetry.csv_lines(rows).encode()


def read_names(lines: Iterator[str]) -> tuple[str, ...]:
    """Return the names of the columns, from the first line that is no comment."""
    for line in islice(lines, COMMENTS_MAX + 1):
        if not line.startswith(_COMMENT):
            return tuple(line.strip().split(","))
    raise NotTelemetry("it has no columns")


def read_blocks(lines: Iterable[str], width: int) -> Iterator[Rows]:
    """Yield the rows below the names, `WRITTEN_ROWS` at a time; raises NotTelemetry."""
    left = iter(lines)
    while block := list(islice(left, WRITTEN_ROWS)):
        if not all(map(str.strip, block)):
            raise NotTelemetry("a line is empty")
        try:
            rows = np.loadtxt(block, delimiter=",", ndmin=2, comments=None)
        except ValueError as error:
            raise NotTelemetry(str(error)) from None
        if rows.shape[1] != width:
            raise NotTelemetry(f"a row has {rows.shape[1]} numbers instead of {width}")
        yield rows
