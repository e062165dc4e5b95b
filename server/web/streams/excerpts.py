"""Excerpts of a run's files: at most so many bytes, whatever the length or speed of the run."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from seamark.server.runs.data.files import RunFiles
from seamark.server.web.streams import events
from seamark.server.web.streams.events import Frame, Position
from seamark.sim.recording.telemetry import INDEX, STEP_US

_SAMPLE = 8  # rows that show how many bytes a row takes
_EXACT = ("trial", "level", "t")  # at 6000 s, a time of 0.05 s needs seven digits


@dataclass(frozen=True, slots=True)
class Budget:
    """How much an excerpt may hold [byte]; column names and a row are always sent."""

    telemetry: int
    log: int


START = Budget(telemetry=38_000, log=8_000)  # for a new viewer


@dataclass(frozen=True, slots=True)
class Excerpt:
    """Events, and the position after them."""

    frames: tuple[Frame, ...]
    end: Position


def position_now(files: RunFiles) -> Position:
    """Return the position after everything that is in the files."""
    return Position(files.attempt, files.row_count(), files.log_length())


def start_of_trial(files: RunFiles) -> Position:
    """Return the position of the first row of the newest trial, after the log so far."""
    now = position_now(files)
    if now.row == 0:
        return now
    trial = int(files.rows(now.row - 1, now.row)[0, INDEX["trial"]])
    return replace(now, row=files.rows_until(trial, float("-inf")))


def excerpt(files: RunFiles, since: Position, until: Position, budget: Budget) -> Excerpt:
    """Return what the files have between two positions, thinned evenly to the budget.

    The newest row is always among them. A position of an earlier attempt counts as the start.
    """
    if since.attempt != until.attempt:
        since = Position(until.attempt, 0, 0)
    frames = []
    if since.row < until.row:
        frames.append(_telemetry(files, since, until, budget))
    if since.log < until.log:
        frames.append(_log(files, since, until, budget))
    return Excerpt(tuple(frames), until)


def _telemetry(files: RunFiles, since: Position, until: Position, budget: Budget) -> Frame:
    names = list(files.columns)
    del names[STEP_US]
    sample = _row_texts(files, _spread(since.row, until.row, _SAMPLE), names)
    row_bytes = sum(map(len, sample)) / max(len(sample), 1) + 1
    fitting = max(int(budget.telemetry / row_bytes), 1)
    rows = _row_texts(files, _spread(since.row, until.row, fitting), names)
    return events.telemetry(replace(until, log=since.log), names, rows)


def _row_texts(files: RunFiles, indices: list[int], names: list[str]) -> list[str]:
    exact = [name in _EXACT for name in names]
    rows = np.delete(files.rows_at(indices), STEP_US, axis=1).tolist()
    return [events.row_text(row, exact) for row in rows]


def _spread(start: int, stop: int, count: int) -> list[int]:
    """Return at most `count` indices, evenly from a range; its last one is among them."""
    length = stop - start
    count = min(count, length)
    return [start + (at + 1) * length // count - 1 for at in range(count)]


def _log(files: RunFiles, since: Position, until: Position, budget: Budget) -> Frame:
    start = max(since.log, until.log - budget.log)
    part = files.log(start, until.log)
    gap = start > since.log or part.dropped > 0
    text = part.text
    frame = events.log(until, text, gap=gap)
    while len(frame.data) > budget.log and text:  # escapes make it longer
        text = text[len(text) // 4 + 1 :]
        frame = events.log(until, text, gap=True)
    return frame
