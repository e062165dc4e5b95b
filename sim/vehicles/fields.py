"""Quantities, names and lists in the tables of a file, checked one by one.

Every mistake becomes a sentence that names the key and says what to do. They are collected, so that
a user sees all of them at once.
"""

import difflib
import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from seamark.sim.vehicles.model import TAGS, Quantity

TEXT_MAX = 400  # characters
NAME_MAX = 40  # characters
ERRORS_MAX = 20  # more are not listed
SOURCES_MAX = 200
UNIT_VECTOR_ERROR = 1e-6
LARGEST = 1e9  # of any number, in its unit
_NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")
_SOURCE = re.compile(rf"[A-Za-z0-9_-]{{1,{NAME_MAX}}}")
QUANTITY_KEYS = ("value", "unit", "tag", "source", "reason", "meaning", "spread")
Table = Mapping[str, Any]


class FileInvalid(Exception):
    """A file breaks rules. The sentences are written for the user, the first `ERRORS_MAX` of them.

    Attributes
    ----------
    errors : sequence of sentences
    """

    def __init__(self, errors: Sequence[str]) -> None:
        more = len(errors) - ERRORS_MAX
        rest = [f"{more} more mistakes are not listed."] if more > 0 else []
        self.errors = (*errors[:ERRORS_MAX], *rest)
        super().__init__(" ".join(self.errors))


@dataclass(frozen=True, slots=True)
class Slot:
    """What a quantity of the format must be."""

    meaning: str
    unit: str
    counts: range
    low: float | None = None
    above: float | None = None


def vector(meaning: str, unit: str, **limits: float) -> Slot:
    """Return the slot of three numbers."""
    return Slot(meaning, unit, range(3, 4), **limits)


def number(meaning: str, unit: str, **limits: float) -> Slot:
    """Return the slot of a single number."""
    return Slot(meaning, unit, range(1, 2), **limits)


def not_given(slot: Slot, value: float = 0.0) -> Quantity:
    """Return what stands for a quantity that is not given."""
    return Quantity(
        meaning=slot.meaning,
        value=(value,) * slot.counts[0],
        unit=slot.unit,
        tag="E",
        source="not given",
    )


def unit_of(text: str) -> str:
    """Return a unit as this project writes it, such as "kg m²" for "kg*m^2"."""
    for written, ours in (("^2", "²"), ("**2", "²"), ("*", " "), ("·", " ")):
        text = text.replace(written, ours)
    return " ".join(text.split())


class Fields:
    """Reads the fields of one document.

    Attributes
    ----------
    errors : list of sentences
    """

    def __init__(self, document: Table) -> None:
        self.errors: list[str] = []
        self.document = document
        self._sources = self._read_sources()

    def _read_sources(self) -> dict[str, str]:
        table = self.table("", self.document, "sources", required=False)
        if len(table) > SOURCES_MAX:
            self.wrong(f"sources: there are {len(table)}; at most {SOURCES_MAX} are read.")
            return {}
        for key in table:
            if not _SOURCE.fullmatch(key):
                self.wrong(
                    f"sources: {quoted(key)} must be at most {NAME_MAX} letters, digits, hyphens "
                    "and underscores."
                )
                return {}
        return {key: self.text("sources", table, key) for key in table}

    def quantity(
        self, path: str, table: Table, key: str, slot: Slot, more: Collection[str] = ()
    ) -> Quantity:
        """Return a quantity of a table by its key; `more` are further keys that it may have."""
        entry = table.get(key)
        if not isinstance(entry, dict):
            example = f'{{ value = ..., unit = "{slot.unit}", tag = "E", reason = "..." }}'
            what = "missing" if entry is None else "no table"
            self.wrong(f"{path}.{key} is {what}: write {key} = {example}.")
            value = (0.5,) * slot.counts[0]
            return Quantity(meaning=slot.meaning, value=value, unit=slot.unit, tag="E", source="")
        return self.read_quantity(f"{path}.{key}", entry, slot, more)

    def read_quantity(
        self, path: str, entry: Table, slot: Slot, more: Collection[str] = ()
    ) -> Quantity:
        """Return the quantity of a table of its own."""
        self.known(path, entry, (*QUANTITY_KEYS, *more))
        value = self._values(f"{path}.value", entry.get("value"), slot)
        unit = entry.get("unit")
        if unit is None:
            self.wrong(f'{path}: unit is missing; write unit = "{slot.unit}".')
        elif not isinstance(unit, str) or unit_of(unit) != slot.unit:
            self.wrong(
                f'{path}.unit must be "{slot.unit}", not {quoted(unit)}: numbers are not converted.'
            )
        tag = entry.get("tag")
        if tag not in tuple(TAGS):
            meanings = "; ".join(f"{name}, {text}" for name, text in TAGS.items())
            self.wrong(f"{path}.tag says where the number is from and must be one of: {meanings}.")
        meaning = self.text(path, entry, "meaning") if "meaning" in entry else slot.meaning
        return Quantity(
            meaning=meaning,
            value=value,
            unit=slot.unit,
            tag=next((known for known in TAGS if known == tag), "E"),
            source=self._source(path, entry),
            spread=self._spread(path, entry["spread"], slot, value) if "spread" in entry else None,
        )

    def _source(self, path: str, entry: Table) -> str:
        parts = []
        if "source" in entry:
            name = entry["source"]
            if not isinstance(name, str) or name not in self._sources:
                self.wrong(
                    f"{path}.source: {quoted(name)} is not in [sources]; add a line there with "
                    'this name, such as tank = "author, year, where".'
                )
            else:
                parts.append(self._sources[name])
        elif entry.get("tag") in ("S", "M"):
            self.wrong(f"{path}: source is missing; tag {entry['tag']} needs one from [sources].")
        if "reason" in entry:
            parts.append(self.text(path, entry, "reason"))
        if not parts and entry.get("tag") not in ("S", "M"):
            self.wrong(f"{path}: write a source from [sources], or a reason.")
        return ", ".join(parts)

    def _spread(
        self, path: str, given: object, slot: Slot, value: tuple[float, ...]
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return the least and greatest values that sources give."""
        if not isinstance(given, list) or len(given) != 2:
            self.wrong(f"{path}.spread must be [low, high], each as value is.")
            return value, value
        slot = replace(slot, counts=range(len(value), len(value) + 1))
        low, high = (self._values(f"{path}.spread", one, slot) for one in given)
        if not all(a <= b <= c for a, b, c in zip(low, value, high, strict=True)):
            self.wrong(f"{path}.spread must enclose the value.")
        return low, high

    def _values(self, path: str, given: object, slot: Slot) -> tuple[float, ...]:
        listed = given if isinstance(given, list) else [given]
        if len(listed) not in slot.counts or given is None:
            least, most = slot.counts[0], slot.counts[-1]
            some = f"{least}" if least == most else f"{least} to {most}"
            what = "a number" if most == 1 else f"a list of {some} numbers"
            self.wrong(f"{path} must be {what} [{slot.unit}].")
            return (0.5,) * least
        return tuple(self.plain(path, one, low=slot.low, above=slot.above) for one in listed)

    def plain(
        self, path: str, given: object, *, low: float | None = None, above: float | None = None
    ) -> float:
        """Return a finite number within its limits."""
        if isinstance(given, bool) or not isinstance(given, int | float):
            self.wrong(f"{path} must be a number, not {quoted(given)}.")
            return 0.5
        if not -LARGEST <= given <= LARGEST:  # NaN too
            self.wrong(f"{path} must be a finite number of at most {LARGEST:g} in size.")
            return 0.5
        value = float(given)
        if (low is not None and value < low) or (above is not None and value <= above):
            limit = f"at least {low:g}" if low is not None else f"above {above:g}"
            self.wrong(f"{path} must be {limit}, not {value:g}.")
        return value

    def triple(
        self, path: str, given: object, *, above: float | None = None
    ) -> tuple[float, float, float]:
        """Return three numbers without a source: x, y, z."""
        if not isinstance(given, list) or len(given) != 3:
            self.wrong(f"{path} must be a list of three numbers: x forward, y starboard, z down.")
            return 1.0, 0.0, 0.0
        x, y, z = (self.plain(path, one, above=above) for one in given)
        return x, y, z

    def choice(self, path: str, given: object, choices: Sequence[str]) -> str:
        """Return one of the choices."""
        if given not in choices:
            self.wrong(f"{path} must be one of {', '.join(choices)}, not {quoted(given)}.")
            return choices[0]
        return str(given)

    def name(self, document: Table) -> str:
        """Return the name that the document's thing is chosen by."""
        name = self.text("", document, "name")
        if name:
            self.is_name("name", name)
        return name

    def is_name(self, path: str, name: str) -> bool:
        """Return whether a vehicle, an arm or a thing can have this name; refuse it if not."""
        good = len(name) <= NAME_MAX and _NAME.fullmatch(name) is not None
        if not good:
            self.wrong(
                f"{path} must be at most {NAME_MAX} small letters, digits and single hyphens "
                f"between them, not {quoted(name)}."
            )
        return good

    def text(self, path: str, table: Table, key: str) -> str:
        """Return a text of one line."""
        name, text = f"{path}.{key}" if path else key, table.get(key)
        if not isinstance(text, str) or not text.strip():
            self.wrong(f'{name} is missing: write {key} = "...".')
            return ""
        if len(text) > TEXT_MAX or not text.isprintable():
            self.wrong(f"{name} must be at most {TEXT_MAX} printable characters in one line.")
            return ""
        return text

    def table(self, path: str, table: Table, key: str, *, required: bool) -> Table:
        """Return a table; an empty one if it is missing and may be."""
        value = table.get(key)
        if isinstance(value, dict):
            return value
        if value is not None or required:
            name = f"{path}.{key}" if path else key
            what = "missing" if value is None else "no table"
            self.wrong(f"{name} is {what}: write a line [{name}], and its keys below.")
        return {}

    def tables(self, path: str, table: Table, key: str, most: int) -> list[Table]:
        """Return a list of 1 to `most` tables."""
        name, tables = f"{path}.{key}" if path else key, table.get(key)
        if not isinstance(tables, list) or not all(isinstance(one, dict) for one in tables):
            what = "missing" if tables is None else "no list of tables"
            self.wrong(f"{name} is {what}.")
            return []
        if not 1 <= len(tables) <= most:
            self.wrong(f"{name}: there must be 1 to {most}, not {len(tables)}.")
            return []
        return tables

    def named(self, key: str, most: int) -> list[tuple[str, Table]]:
        """Return path and table of each entry of a list; their names differ."""
        named: list[tuple[str, Table]] = []
        names: set[str] = set()
        for at, entry in enumerate(self.tables("", self.document, key, most), start=1):
            path = f"{key} {at}"
            name = self.text(path, entry, "name")
            if name in names:
                self.wrong(f"{path}.name: {quoted(name)} is taken; give each its own.")
            names.add(name)
            named.append((f"{path} ({name})" if name else path, {**entry, "name": name}))
        return named

    def known(self, path: str, table: Table, keys: Collection[str]) -> None:
        """Refuse keys that a table does not have."""
        for key in table:
            if key not in keys:
                near = difflib.get_close_matches(key[:NAME_MAX], keys, n=1)
                hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(keys)}."
                where = f" in {path}" if path else ""
                self.wrong(f"{quoted(key)}{where} is unknown; {hint}")
                if len(self.errors) > ERRORS_MAX:
                    return

    def wrong(self, sentence: str) -> None:
        """Note a mistake."""
        self.errors.append(sentence)

    def direction(self, path: str, given: object) -> tuple[float, float, float]:
        """Return a unit vector."""
        x, y, z = self.triple(path, given)
        length = math.hypot(x, y, z)
        if length == 0.0:
            self.wrong(f"{path} must not be zero.")
        elif abs(length - 1.0) > UNIT_VECTOR_ERROR:
            unit = ", ".join(repr(value / length) for value in (x, y, z))
            self.wrong(f"{path} must have length 1, not {length:g}: write [{unit}].")
        return x, y, z


def quoted(value: object) -> str:
    """Return a value as a message shows it, short and printable."""
    if value is None:
        return "nothing"
    if isinstance(value, int) and abs(value) > LARGEST:
        return "a very large number"
    if isinstance(value, list | dict):
        return "a list" if isinstance(value, list) else "a table"
    text = repr(value)
    return text if len(text) <= NAME_MAX + 2 else f"{text[:NAME_MAX]}…"
