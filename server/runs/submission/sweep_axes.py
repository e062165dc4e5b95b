"""The axes of a sweep: a name with its values, given as a list or as a text."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from seamark.programs.setting_values import text_of
from seamark.server.runs.submission.validation import SubmissionRejected

AXES_MAX = 2
RUNS_MAX = 64  # of a sweep, so also values of an axis
TEXT_MAX = 2000  # [character] of the values of one axis
NUMBER_MAX = 40  # [character] of one number
_DIGITS = 12  # significant ones of computed values
Value = bool | int | float | str


@dataclass(frozen=True, slots=True)
class Axis:
    """What is swept, and its values in order."""

    name: str
    values: tuple[Value, ...]


def read_axis(name: str, values: Sequence[Value] | str) -> Axis:
    """Return an axis; raises SubmissionRejected.

    Parameters
    ----------
    values
        A list, or a text: values with commas, or `from:to:count` for evenly spaced numbers.
    """
    read = _from_text(name, values[:TEXT_MAX]) if isinstance(values, str) else list(values)
    if not 2 <= len(read) <= RUNS_MAX:
        raise _refused(f"Give 2 to {RUNS_MAX} values of {name}, such as 0.1, 0.2, 0.5 or 0.1:1:10.")
    if any(isinstance(value, float) and not math.isfinite(value) for value in read):
        raise _refused(f"The values of {name} must be finite.")
    texts = [text_of(value) for value in read]
    twice = next((text for text in texts if texts.count(text) > 1), None)
    if twice is not None:
        raise _refused(f"The value {twice[:NUMBER_MAX]} of {name} is listed twice.")
    return Axis(name, tuple(read))


def shown(value: Value) -> str:
    """Return a value as people write it: 0.3, not 0.30000000000000004."""
    if isinstance(value, float) and math.isfinite(value):
        value = float(f"{value:.{_DIGITS}g}")
    return text_of(value)


def numbers_of(values: Sequence[Value]) -> list[float] | None:
    """Return the values as numbers; None if they are choices."""
    if any(isinstance(value, bool | str) for value in values):
        return None
    return [float(value) for value in values]


def _refused(sentence: str) -> SubmissionRejected:
    return SubmissionRejected(sentence, field="sweep")


def _from_text(name: str, text: str) -> list[Value]:
    parts = text.split(":")
    if len(parts) == 1:
        return [_value(part.strip()) for part in text.split(",") if part.strip()]
    try:
        first, last, count = (float(parts[0]), float(parts[1]), int(parts[2]))
    except (ValueError, IndexError):
        first, last, count = math.nan, math.nan, 0
    if len(parts) > 3 or not math.isfinite(first + last) or not 2 <= count <= RUNS_MAX:
        raise _refused(
            f"{name}: write a range as from:to:count, such as 0.1:1:10; count is 2 to {RUNS_MAX}."
        )
    step = (last - first) / (count - 1)
    return [_value(f"{first + at * step:.{_DIGITS}g}") for at in range(count)]


def _value(text: str) -> Value:
    for convert in (int, float):
        try:
            return convert(text[:NUMBER_MAX])
        except ValueError:
            continue
    return text
