"""What a file format needs of a run, wherever the run is kept."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.recording import telemetry
from seamark.sim.recording.manifest import versions
from seamark.sim.recording.telemetry import Column, Rows
from seamark.sim.vehicles.patterns import CLASSES

BLOCK_ROWS = 10_000  # read at a time: 4 MB
FRAMES = "world: north, east, down (NED); body: x forward, y starboard, z down"
_TYPE = "<f8"


class RowsGone(Exception):
    """Rows that were there when the writing began have been removed, as a live run may do."""


class FormatRefused(Exception):
    """The run cannot be written in this format. The text is for the user."""


@dataclass(frozen=True, slots=True)
class Program:
    """The uploaded program of a run."""

    name: str
    content: bytes


@dataclass(frozen=True, kw_only=True)
class Recording:
    """A run: its rows, and the documents that describe it.

    Attributes
    ----------
    read
        Returns the rows from the first number to before the second, shape (k, number of columns).
    seeds
        Of each trial, to render camera images; None where they are not known.
    comments
        Lines above the rows of a CSV.
    parts
        Role -> further program that was uploaded.
    extra_files
        Name -> text of further files for the archive.
    """

    title: str
    benchmark: str
    config: Mapping[str, Any]
    width: int  # columns
    row_count: int
    read: Callable[[int, int], Rows]
    seeds: Sequence[int] | None = None
    comments: Sequence[str] = ()
    manifest: Mapping[str, Any] | None = None
    metrics: Mapping[str, Any] | None = None
    program: Program | None = None
    parts: Mapping[str, Program] = field(default_factory=dict)
    extra_files: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The columns of the rows."""
        return telemetry.columns(self.width)

    @property
    def dtype(self) -> np.dtype[np.void]:
        """The type of a row with named columns.

        Those of a detector are nested, `row["object"][0]["x0"]`: NumPy loads no array with so many
        fields, since their names are more than 10,000 characters.
        """
        detections = telemetry.detections_slice(self.width)
        nested: list[Any] = [
            ("object", _fields(telemetry.OBJECT_COLUMNS), (len(CLASSES),)),
            ("answer", _fields(telemetry.ANSWER_COLUMNS), (telemetry.ANSWERS,)),
        ]
        return np.dtype(
            [
                *_fields(self.columns[: detections.start]),
                *(nested if telemetry.has_detections(self.width) else ()),
                *_fields(self.columns[detections.stop :]),
            ]
        )

    def blocks(self, size: int = BLOCK_ROWS) -> Iterator[Rows]:
        """Yield all rows in order, at most `size` at a time; raises RowsGone."""
        for start in range(0, self.row_count, size):
            stop = min(start + size, self.row_count)
            rows = self.read(start, stop)
            if len(rows) != stop - start:
                raise RowsGone(f"{self.title}: rows {start} to {stop} are not there any more")
            yield rows

    def columns_at(self, first: int, count: int) -> NDArray[np.float64]:
        """Return some columns of all rows, shape (count, rows), each in one piece."""
        parts = np.empty((count, self.row_count))
        at = 0
        for rows in self.blocks():
            parts[:, at : at + len(rows)] = rows[:, first : first + count].T
            at += len(rows)
        return parts

    def description(self) -> str:
        """Return what every file says about the run, as JSON."""
        manifest = self.manifest or {}
        told: dict[str, Any] = {
            "title": self.title,
            "benchmark": self.benchmark,
            "configuration": self.config,
            "frames": FRAMES,
            "written_by": f"seamark {versions()['seamark']}",
        }
        told |= {name: manifest[name] for name in ("seed", "trials", "digest") if name in manifest}
        return json.dumps(told, sort_keys=True, allow_nan=False)


def _fields(columns: Sequence[Column]) -> list[tuple[str, str]]:
    return [(column.name, _TYPE) for column in columns]
