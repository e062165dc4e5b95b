"""Live events as bytes of text/event-stream, made once whatever the number of viewers.

The id of an event is the place in the run's files after which a viewer resumes.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

STATE, TELEMETRY, LOG, END = "state", "telemetry", "log", "end"
RECONNECT_MS = 2000  # how long a browser waits before it reconnects
_NUMBER_MAX = 10**15  # of a position that somebody sends


@dataclass(frozen=True, slots=True)
class Position:
    """A place in the files of a run; as text `attempt-row-byte`."""

    attempt: int
    row: int  # rows of telemetry before it
    log: int  # [byte] of the log before it

    def __str__(self) -> str:
        """Return the text that `parse` reads."""
        return f"{self.attempt}-{self.row}-{self.log}"

    def is_beyond(self, other: Position) -> bool:
        """Return whether something of the files lies between `other` and this position."""
        if self.attempt != other.attempt:
            return self.attempt > other.attempt
        return self.row > other.row or self.log > other.log

    @classmethod
    def parse(cls, text: str | None) -> Position | None:
        """Return the position; None if this is none, since clients may send anything."""
        parts = (text or "").split("-")
        if len(parts) != 3 or not all(p.isascii() and p.isdecimal() for p in parts):
            return None
        numbers = [int(part) for part in parts if len(part) <= len(str(_NUMBER_MAX))]
        return cls(*numbers) if len(numbers) == 3 else None


@dataclass(frozen=True, slots=True)
class Frame:
    """The bytes of one or more events of one type."""

    type: str
    data: bytes


def greeting() -> bytes:
    """Return how soon a client should connect again."""
    return f"retry: {RECONNECT_MS}\n\n".encode()


def state(values: Mapping[str, Any]) -> Frame:
    """Return a state event. It has no id, so that viewers resume after the data before it."""
    return Frame(STATE, f"event: {STATE}\ndata: {json.dumps(values)}\n\n".encode())


def end() -> Frame:
    """Return the event after which nothing follows."""
    return Frame(END, f"event: {END}\ndata: {{}}\n\n".encode())


def telemetry(position: Position, columns: Sequence[str], rows: Sequence[str]) -> Frame:
    """Return rows, each formatted by `row_text`."""
    names = json.dumps(list(columns), separators=(",", ":"))
    data = f'{{"columns":{names},"rows":[{",".join(rows)}]}}'
    return Frame(TELEMETRY, _event(position, TELEMETRY, data))


def log(position: Position, text: str, *, gap: bool) -> Frame:
    """Return output of the program; with `gap`, some output before it was left out."""
    data = json.dumps({"text": text, "gap": gap}, ensure_ascii=False)
    return Frame(LOG, _event(position, LOG, data))


def row_text(row: Sequence[float], exact: Sequence[bool]) -> str:
    """Return a row as a JSON array: five digits suffice for a screen, `exact` values have seven."""
    cells = (_number(value, 7 if long else 5) for value, long in zip(row, exact, strict=True))
    return f"[{','.join(cells)}]"


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}g}" if math.isfinite(value) else "null"


def _event(position: Position, event_type: str, data: str) -> bytes:
    return f"id: {position}\nevent: {event_type}\ndata: {data}\n\n".encode()
