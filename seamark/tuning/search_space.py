"""What is tuned: a setting or parameter of a solution, with its range or its values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from seamark.failures import UsageRefused

Value = bool | int | float | str
Schema = Mapping[str, Any]  # of one setting or parameter, in a benchmark's JSON Schema
DIMENSIONS_MAX = 20
VALUES_MAX = 100  # of a list
NEAR_ZERO = 1e-3  # of the upper end: below it a logarithmic range from 0 is nearly linear; E
_DIGITS = 5  # significant ones of a value, so that a file shows all of it
_SYNTAX = "write it as {name}=0.1:2, {name}=0.1:2:log or {name}=0.1,0.5,1."


@dataclass(frozen=True, slots=True, kw_only=True)
class Dimension:
    """One setting or parameter: a range of numbers, or a list of values."""

    name: str
    low: float = 0.0
    high: float = 1.0
    logarithmic: bool = False
    whole: bool = False
    values: tuple[Value, ...] = ()  # not empty: these instead of the range

    def value_at(self, share: float) -> Value:
        """Return the value at a share of the range from 0 to 1; only of a range."""
        if self.logarithmic:
            offset, factor = self._logarithm()
            value = offset * factor**share - (offset if self.low == 0.0 else 0.0)
        else:
            value = self.low + share * (self.high - self.low)
        value = min(max(float(f"{value:.{_DIGITS}g}"), self.low), self.high)
        return round(value) if self.whole else value

    def share_of(self, value: float) -> float:
        """Return the share of the range that gives a value, limited to 0 to 1."""
        inside = min(max(value, self.low), self.high)
        if not self.logarithmic:
            return (inside - self.low) / (self.high - self.low)
        offset, factor = self._logarithm()
        ratio = (inside + offset if self.low == 0.0 else inside) / offset
        return math.log(ratio) / math.log(factor)

    def grid(self, count: int) -> tuple[Value, ...]:
        """Return all values of a list, or `count` distinct ones at equal shares of the range."""
        if self.values:
            return self.values
        if count == 1:
            return (self.value_at(0.5),)
        return tuple(dict.fromkeys(self.value_at(at / (count - 1)) for at in range(count)))

    def _logarithm(self) -> tuple[float, float]:
        """Return offset and factor of the range, which is `offset * factor**share`.

        A range from 0 is shifted by `offset`, since it has no logarithm at its lower end.
        """
        if self.low > 0.0:
            return self.low, self.high / self.low
        offset = NEAR_ZERO * self.high
        return offset, (self.high + offset) / offset

    def to_json(self) -> dict[str, Any]:
        """Return what the history stores, to recognise the same search again."""
        if self.values:
            return {"name": self.name, "values": list(self.values)}
        return {
            "name": self.name,
            "range": [self.low, self.high],
            "log": self.logarithmic,
            "whole": self.whole,
        }


def read_dimensions(texts: Sequence[str], tunable: Mapping[str, Schema]) -> tuple[Dimension, ...]:
    """Return the dimensions of a search.

    Parameters
    ----------
    texts
        `NAME` for the range that the setting or parameter declares, or `NAME=LOW:HIGH`,
        `NAME=LOW:HIGH:log`, `NAME=VALUE,VALUE`.
    tunable
        Name -> schema of everything that can be tuned.

    Raises
    ------
    UsageRefused
        With a sentence that says how to write it.
    """
    dimensions = tuple(_read(text, tunable) for text in texts)
    names = [one.name for one in dimensions]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise UsageRefused(f"--param {twice} is listed twice.")
    if not 1 <= len(dimensions) <= DIMENSIONS_MAX:
        raise UsageRefused(f"Give 1 to {DIMENSIONS_MAX} parameters with --param.")
    return dimensions


def _read(text: str, tunable: Mapping[str, Schema]) -> Dimension:
    name, equals, given = (part.strip() for part in text.partition("="))
    if name not in tunable:
        known = ", ".join(tunable) or "none"
        raise UsageRefused(f"--param {name}: it cannot be tuned here. These can: {known}.")
    schema = tunable[name]
    if not equals:
        return _declared(name, schema)
    return _range(name, given, schema) if ":" in given else _list(name, given, schema)


def _declared(name: str, schema: Schema) -> Dimension:
    """Return the whole range or all values of a setting or parameter."""
    if schema["type"] == "boolean":
        return Dimension(name=name, values=(False, True))
    if schema.get("enum"):
        return Dimension(name=name, values=tuple(schema["enum"]))
    low, high = _limits(schema)
    if not math.isfinite(low) or not math.isfinite(high) or low == high:
        raise UsageRefused(f"--param {name} declares no range: " + _SYNTAX.format(name=name))
    return Dimension(name=name, low=low, high=high, whole=schema["type"] == "integer")


def _limits(schema: Schema) -> tuple[float, float]:
    """Return the lowest and the highest value; a limit that is excluded is left by 0.1 %."""
    low, high = schema.get("minimum", -math.inf), schema.get("maximum", math.inf)
    if "exclusiveMinimum" in schema:
        above = float(schema["exclusiveMinimum"])
        low = above + (NEAR_ZERO * (high - above) if math.isfinite(high) else 0.0)
    return float(low), float(high)


def _range(name: str, given: str, schema: Schema) -> Dimension:
    ends, (scale, *more) = given.split(":")[:2], [*given.split(":")[2:], ""][:2]
    low, high = (_number(name, end) for end in ends)
    if schema["type"] not in ("number", "integer"):
        raise UsageRefused(f"--param {name} is not a number: list its values instead.")
    if more not in ([], [""]) or scale not in ("", "log") or given.count(":") > 2:
        raise UsageRefused(f"--param {name}={given}: " + _SYNTAX.format(name=name))
    if not low < high:
        raise UsageRefused(f"--param {name}={given}: the first end must be below the second.")
    if scale and low < 0.0:
        raise UsageRefused(f"--param {name}={given}: a logarithmic range starts at 0 or above.")
    lowest, highest = schema.get("minimum", -math.inf), schema.get("maximum", math.inf)
    if low < max(lowest, schema.get("exclusiveMinimum", -math.inf)) or high > highest:
        limits = " to ".join(f"{limit:g}" for limit in _limits(schema))
        raise UsageRefused(f"--param {name}={given}: {name} may be from {limits}.")
    if "exclusiveMinimum" in schema and low == schema["exclusiveMinimum"]:
        low += NEAR_ZERO * (high - low)
    whole = schema["type"] == "integer"
    return Dimension(name=name, low=low, high=high, logarithmic=bool(scale), whole=whole)


def _number(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageRefused(
            f"--param {name}: {text[:40]} is not a number; " + _SYNTAX.format(name=name)
        )
    return value


def _list(name: str, given: str, schema: Schema) -> Dimension:
    texts = [part.strip() for part in given.split(",") if part.strip()]
    values = tuple(_value(name, text, schema) for text in texts)
    if not 1 <= len(values) <= VALUES_MAX or len(set(texts)) < len(texts):
        raise UsageRefused(f"--param {name}: give 1 to {VALUES_MAX} different values.")
    return Dimension(name=name, values=values)


def _value(name: str, text: str, schema: Schema) -> Value:
    match schema["type"]:
        case "boolean":
            if text.lower() not in ("true", "false"):
                raise UsageRefused(f"--param {name}: {text[:40]} is neither true nor false.")
            return text.lower() == "true"
        case "integer" | "number" as kind:
            number = _number(name, text)
            return int(number) if kind == "integer" and number.is_integer() else number
    return text
