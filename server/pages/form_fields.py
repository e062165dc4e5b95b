"""Form fields generated from a benchmark's JSON Schema, and their texts read back as values."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

Schema = Mapping[str, Any]
_LABEL_MAX = 22  # [character] that one column of the form can show


@dataclass(frozen=True, slots=True)
class Field:
    """One field of the form; everything the template needs and no rule of its own."""

    name: str
    title: str
    help: str
    unit: str
    kind: str  # "choice", "check", "number", "list" or "text"
    value: str
    default: str
    options: tuple[tuple[str, str], ...]  # value, label
    low: float | None
    high: float | None
    step: str
    range: str
    tag: str
    source: str
    advanced: bool
    error: str
    names: tuple[str, ...] = ()  # that an expression may have in it
    applies: Mapping[str, Sequence[str]] = field(default_factory=dict)  # as `applying` takes it
    only: str = ""  # the same in words

    @property
    def wide(self) -> bool:
        """Whether a label among the options is too long for one column."""
        return any(len(label) > _LABEL_MAX for _value, label in self.options)


@dataclass(frozen=True, slots=True)
class Group:
    """Fields that belong together; `scenario` says that a ranked run fixes them."""

    title: str
    scenario: bool
    shown: tuple[Field, ...]
    folded: tuple[Field, ...]

    @property
    def folded_error(self) -> bool:
        """Whether a field that is folded away has an error; then it is unfolded."""
        return any(one.error for one in self.folded)


def groups(
    schema: Schema,
    values: Mapping[str, object],
    errors: Mapping[str, str],
    *,
    order: Sequence[str] = (),
) -> tuple[Group, ...]:
    """Return the form, its groups in the order given, then in the schema's.

    Parameters
    ----------
    values
        Setting -> value or text to show; what is missing shows the default.
    errors
        Setting -> sentence, shown at the field.
    """
    preset = preset_of(schema, values)
    found: dict[tuple[bool, str], list[Field]] = {}
    for name, entry in schema["properties"].items():
        default = preset.get(name, entry.get("default"))
        shown = values.get(name, default)
        key = (entry.get("x-role") == "scenario", entry.get("x-group", ""))
        one = _field(name, entry, shown=shown, default=default, error=errors.get(name, ""))
        only = _only(schema, entry.get("x-applies", {}))
        found.setdefault(key, []).append(replace(one, only=only))
    places = {title: at for at, title in enumerate(order)}
    ordered = sorted(found.items(), key=lambda item: places.get(item[0][1], len(places)))
    return tuple(
        Group(
            title=title,
            scenario=scenario,
            shown=tuple(one for one in members if not one.advanced),
            folded=tuple(one for one in members if one.advanced),
        )
        for (scenario, title), members in ordered
    )


def read(schema: Schema, form: Mapping[str, str]) -> dict[str, object]:
    """Return the values of a posted form; what is no number stays text, for the sentence about it.

    A checkbox that is not ticked is not posted: `<name>.there` says that the form had it.
    """
    values: dict[str, object] = {}
    for name, entry in schema["properties"].items():
        if entry["type"] == "boolean":
            if f"{name}.there" in form or name in form:
                values[name] = form.get(name) in {"on", "true", "1"}
        elif name in form:
            values[name] = _value(entry, form[name].strip())
    return values


def solution(schema: Schema, values: Mapping[str, object]) -> dict[str, object]:
    """Return the values of the settings that compete, without those of the scenario."""
    entries = schema["properties"]
    return {name: v for name, v in values.items() if entries[name].get("x-role") == "solution"}


def preset_of(schema: Schema, values: Mapping[str, object]) -> Mapping[str, object]:
    """Return the values that come with the choices among others, such as a vehicle's."""
    preset: dict[str, object] = {}
    for name, choices in schema.get("x-presets", {}).items():
        preset |= choices.get(str(values.get(name, "")), {})
    return preset


def applying(entry: Schema, values: Mapping[str, object]) -> bool:
    """Return whether a setting does anything beside these values of others."""
    return all(
        str(values.get(other)) in allowed for other, allowed in entry.get("x-applies", {}).items()
    )


def _only(schema: Schema, applies: Mapping[str, Sequence[str]]) -> str:
    """Return with which choices a setting does anything, such as "Tracker esm or visp"."""
    return "; ".join(
        f"{schema['properties'][other]['title']} {' or '.join(values)}"
        for other, values in applies.items()
    )


def text_of(value: object) -> str:
    """Return a value as a field shows it."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return ", ".join(text_of(item) for item in value)
    if isinstance(value, float) and value == int(value) and abs(value) < 1e15:
        return str(int(value))
    return str(value)


def _value(entry: Schema, text: str) -> object:
    kind = entry["type"]
    if kind == "array":
        parts = text.replace(";", ",").replace(",", " ").split()
        return [_number(part) for part in parts]
    if kind == "integer":
        return int(text) if text.lstrip("+-").isdecimal() else text
    return _number(text) if kind == "number" else text


def _number(text: str) -> object:
    try:
        value = float(text)
    except ValueError:
        return text
    return value if math.isfinite(value) else text


def _field(name: str, entry: Schema, *, shown: object, default: object, error: str) -> Field:
    numeric = entry["type"] in {"number", "integer"}
    labels = entry.get("x-labels", {})
    return Field(
        name=name,
        title=entry.get("title", name),
        help=entry.get("description", ""),
        unit=entry.get("x-unit", ""),
        kind=_kind(entry),
        value=text_of(shown),
        default=text_of(default),
        options=tuple((text_of(v), labels.get(v, text_of(v))) for v in entry.get("enum", ())),
        low=entry.get("minimum", entry.get("exclusiveMinimum")) if numeric else None,
        high=entry.get("maximum") if numeric else None,
        step="1" if entry["type"] == "integer" else "any",
        range=_range(entry),
        tag=entry.get("x-tag", ""),
        source=entry.get("x-source", ""),
        advanced=bool(entry.get("x-advanced")),
        error=error,
        names=tuple(entry.get("x-names", ())),
        applies=entry.get("x-applies", {}),
    )


def _kind(entry: Schema) -> str:
    if "enum" in entry:
        return "choice"
    kinds = {"boolean": "check", "number": "number", "integer": "number", "array": "list"}
    return kinds.get(entry["type"], "text")


def _range(entry: Schema) -> str:
    """Return the allowed range in words, empty if any value goes."""
    if entry["type"] == "array":
        count = f"{entry.get('minItems', 1)} to {entry.get('maxItems', '∞')} numbers"
        inner = _range({"type": "number", **entry.get("items", {})})
        return f"{count}, {inner}" if inner else count
    low, above, high = (entry.get(k) for k in ("minimum", "exclusiveMinimum", "maximum"))
    start = f"above {_short(above)}" if above is not None else _short(low)
    if high is None:
        return f"from {start}" if low is not None else start
    join = " up to " if above is not None else " to "
    return f"{start}{join}{_short(high)}" if start else f"up to {_short(high)}"


def _short(limit: float | None) -> str:
    return "" if limit is None else f"{limit:.4g}".replace("-", "−")
