"""Numbers and times as they are written in CSV files."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import datetime

_EMPTY = frozenset({"", "nan", "NaN", "NAN", "null", "None"})
_TEXT_MAX = 64  # [character] of a time
# From this number of seconds on, a time without a unit is one since 1970 in a smaller unit.
_SINCE_1970 = ((1e17, "ns"), (1e14, "us"), (1e11, "ms"))
Number = Callable[[str], float]  # raises ValueError


def number(text: str) -> float:
    """Return a number with a decimal point; nan if the text is empty. Raises ValueError."""
    return math.nan if text in _EMPTY else float(text)


def number_with_comma(text: str) -> float:
    """Return a number with a decimal comma or point. Raises ValueError."""
    return number(text.replace(",", ".", 1))


def unit_of_time(text: str, read: Number) -> str:
    """Return the unit of a number of seconds or less, by its size."""
    try:
        size = abs(read(text))
    except ValueError:
        return ""
    return next((unit for least, unit in _SINCE_1970 if size >= least), "")


class Dates:
    """Reads times by ISO 8601, as seconds since the first one."""

    def __init__(self) -> None:
        self._first: datetime | None = None

    def __call__(self, text: str) -> float:
        """Return the seconds since the first time. Raises ValueError."""
        moment = datetime.fromisoformat(text[:_TEXT_MAX])
        self._first = self._first or moment
        try:
            return (moment - self._first).total_seconds()
        except TypeError:  # one has a zone, the other none
            raise ValueError("the times are partly without a zone") from None


def is_date(text: str) -> bool:
    """Return whether a text is a time by ISO 8601 and no number."""
    try:
        datetime.fromisoformat(text[:_TEXT_MAX])
    except ValueError:
        return False
    return not text.isdecimal()
