"""Parameters of a user's own program: declared in its source, set in the form, part of the run.

A configuration holds their values below `KEY`; the program gets them in its `config`, beside the
settings of the benchmark. A parameter with the name of a setting takes the place of that setting.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Self

from seamark.sandbox.languages import LANGUAGES
from seamark.sim.settings.refusal import ConfigurationInvalid

KEY = "parameters"  # in a stored configuration; no benchmark has a setting of this name
COUNT_MAX = 64  # of one program
NAME_MAX, UNIT_MAX, DESCRIPTION_MAX = 60, 30, 200  # [character]
VALUE_MAX = 1e12  # magnitude of a number
Value = bool | int | float
# Beside identifiers the names that exported models have, such as `pid.gain[1]`.
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.\[\]]*")
_BOOLEANS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}


class DeclarationInvalid(Exception):
    """A declaration breaks a rule. The text is for the author of the program."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """One parameter; its type is that of its default: number, whole number, true or false."""

    name: str
    default: Value
    low: float | None = None
    high: float | None = None
    unit: str = ""
    description: str = ""

    def __post_init__(self) -> None:
        """Raise DeclarationInvalid if the name, the default or the range is not allowed."""
        if not _NAME.fullmatch(self.name) or len(self.name) > NAME_MAX:
            raise DeclarationInvalid(
                f"{self.name[:NAME_MAX]} cannot be the name of a parameter: it needs to begin with "
                f"a letter and to have up to {NAME_MAX} letters, digits and underscores."
            )
        if len(self.unit) > UNIT_MAX or len(self.description) > DESCRIPTION_MAX:
            raise DeclarationInvalid(
                f"{self.name}: a unit has up to {UNIT_MAX} characters, a description up to "
                f"{DESCRIPTION_MAX}."
            )
        limits = [limit for limit in (self.low, self.high) if limit is not None]
        if any(not math.isfinite(limit) for limit in limits) or limits != sorted(limits):
            raise DeclarationInvalid(f"{self.name}: the range must be [lowest, highest].")
        if refusal := self.refusal(self.default):
            raise DeclarationInvalid(f"The default of {self.name}: {refusal}")

    @property
    def type(self) -> str:
        """The type of the values, as JSON Schema names it."""
        if isinstance(self.default, bool):
            return "boolean"
        return "integer" if isinstance(self.default, int) else "number"

    def refusal(self, value: object) -> str:
        """Return why a value is not allowed, as a sentence; empty if it is."""
        if self.type == "boolean":
            return "" if isinstance(value, bool) else f"{self.name} must be true or false."
        number = isinstance(value, int | float) and not isinstance(value, bool)
        whole = self.type == "integer"
        kind = "a whole number" if whole else "a number"
        if not number or (whole and not isinstance(value, int)):
            return f"{self.name} must be {kind}{self._range()}, not {str(value)[:40]!r}."
        low = -VALUE_MAX if self.low is None else self.low
        high = VALUE_MAX if self.high is None else self.high
        if not low <= float(str(value)[:400]) <= high:
            return f"{self.name} must be {kind}{self._range()}, not {str(value)[:40]}."
        return ""

    def entry(self) -> dict[str, Any]:
        """Return the JSON Schema of its value, with the same extras as that of a setting."""
        schema: dict[str, Any] = {
            "type": self.type,
            "title": self.name,
            "description": self.description,
            "default": self.default,
            "x-unit": self.unit,
            "x-role": "solution",
        }
        if self.low is not None:
            schema["minimum"] = self.low
        if self.high is not None:
            schema["maximum"] = self.high
        return schema

    def to_json(self) -> dict[str, Any]:
        """Return the JSON object of the API, of the database and of the form."""
        return asdict(self) | {"type": self.type}

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> Self:
        """Return the parameter that `to_json` was given."""
        return cls(**{name: value for name, value in values.items() if name != "type"})

    def _range(self) -> str:
        if self.low is None and self.high is None:
            return ""
        if self.low is None:
            return f" up to {self.high:g}"
        return f" from {self.low:g}" + ("" if self.high is None else f" to {self.high:g}")


def of_benchmark(
    parameters: Sequence[Parameter], language: str, settings: Mapping[str, object]
) -> tuple[Parameter, ...]:
    """Return the parameters that a program has in a benchmark with these settings.

    Those of an FMU that are named as settings are connected to the settings instead: exported
    models name them so for this purpose.
    """
    known = LANGUAGES.get(language)  # None: of a run that an earlier version accepted
    taken = settings if known is not None and known.sets_by_name else ()
    return tuple(one for one in parameters if one.name not in taken)


def schema_of(parameters: Sequence[Parameter]) -> dict[str, Any]:
    """Return the JSON Schema of the values, in the form of a benchmark's schema."""
    return {"type": "object", "properties": {one.name: one.entry() for one in parameters}}


def read(parameters: Sequence[Parameter], given: object) -> dict[str, Value]:
    """Return the value of each parameter: the given one, or its default.

    Raises
    ------
    ConfigurationInvalid
        With a sentence for each value that is not allowed, by `parameters.<name>`.
    """
    if not isinstance(given, Mapping):
        raise ConfigurationInvalid({KEY: "parameters must be an object: name and value."})
    known = {one.name: one for one in parameters}
    errors: dict[str, str] = {}
    values = defaults(parameters)
    for name, sent in given.items():
        if name not in known:
            has = ", ".join(known) or "none"
            shown = str(name)[:NAME_MAX]
            errors[f"{KEY}.{shown}"] = f"The program has no parameter {shown}; it declares {has}."
            continue
        value = _converted(known[name], sent)
        if refusal := known[name].refusal(value):
            errors[f"{KEY}.{name}"] = refusal
        elif isinstance(value, bool | int | float):
            values[name] = value
    if errors:
        raise ConfigurationInvalid(errors)
    return values


def defaults(parameters: Sequence[Parameter]) -> dict[str, Value]:
    """Return the value that each parameter has if nobody chooses one."""
    return {one.name: one.default for one in parameters}


def split(config: Mapping[str, Any]) -> tuple[dict[str, Any], Mapping[str, Any]]:
    """Return the settings of a configuration, and the values of the program's parameters."""
    settings = {name: value for name, value in config.items() if name != KEY}
    return settings, config.get(KEY) or {}


def gathered(config: Mapping[str, Any], parameters: Sequence[Parameter]) -> dict[str, Any]:
    """Return a configuration with the values of parameters below `KEY`.

    The command line and the API may name a parameter like a setting. What is below `KEY` counts: a
    stored configuration has a setting and a parameter of one name.
    """
    below = config.get(KEY) or {}
    if not isinstance(below, Mapping):
        return dict(config)  # `read` refuses it
    names = {one.name for one in parameters} - below.keys()
    beside = {name: value for name, value in config.items() if name in names}
    if not beside:
        return dict(config)
    rest = {name: value for name, value in config.items() if name not in beside}
    return rest | {KEY: {**beside, **below}}


def clean(text: str, limit: int) -> str:
    """Return one line of at most `limit` characters, for units and descriptions."""
    return " ".join(text.split())[:limit]


def _converted(parameter: Parameter, value: object) -> object:
    """Return the value in the type of the parameter; unchanged if it cannot be one."""
    if isinstance(value, str):
        return _from_text(parameter.type, value.strip())
    if parameter.type == "number" and isinstance(value, int) and not isinstance(value, bool):
        return float(value) if abs(value) <= VALUE_MAX else value
    whole = isinstance(value, float) and value.is_integer() and abs(value) <= VALUE_MAX
    if parameter.type == "integer" and whole and isinstance(value, float):
        return int(value)
    return value


def _from_text(kind: str, text: str) -> object:
    if kind == "boolean":
        return _BOOLEANS.get(text.lower(), text)
    try:
        number = float(text)
    except ValueError:
        return text
    if not math.isfinite(number):
        return text
    whole = kind == "integer" and number.is_integer() and abs(number) <= VALUE_MAX
    return int(number) if whole else number
