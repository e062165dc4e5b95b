"""Form fields generated from the JSON Schema of a benchmark, and parsing of their values."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from seamark.programs.setting_values import Schema, text_of

SOLUTION_TITLE = "Solution"
_LABEL_MAX = 22  # [character] that fit into one column of the form


@dataclass(frozen=True, slots=True)
class Field:
    """One field of the form, with everything the template needs."""

    name: str
    title: str
    help: str
    unit: str
    type: str  # "choice", "checkbox", "number", "list" or "text"
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
    names: tuple[str, ...] = ()  # variables available in an expression
    applies: Mapping[str, Sequence[str]] = field(
        default_factory=dict
    )  # see `setting_values.in_effect`
    condition: str = ""  # `applies` in words

    @property
    def changed(self) -> bool:
        """Whether the value differs from the default."""
        return self.value.strip() != self.default

    @property
    def wide(self) -> bool:
        """Whether the label of an option is too long for one column."""
        return any(len(label) > _LABEL_MAX for _value, label in self.options)


@dataclass(frozen=True, slots=True)
class Group:
    """A titled group of fields; ranked runs fix the groups with `scenario`."""

    title: str
    scenario: bool
    basic: tuple[Field, ...]
    advanced: tuple[Field, ...]

    @property
    def changed(self) -> int:
        """How many fields differ from their defaults."""
        return sum(one.changed for one in (*self.basic, *self.advanced))

    @property
    def error(self) -> bool:
        """Whether a field has an error."""
        return any(one.error for one in (*self.basic, *self.advanced))

    @property
    def advanced_open(self) -> bool:
        """Whether an advanced field has to be shown: it differs, or has an error."""
        return any(one.error or one.changed for one in self.advanced)


def groups(
    schema: Schema,
    values: Mapping[str, object],
    errors: Mapping[str, str],
    *,
    order: Sequence[str] = (),
) -> tuple[Group, ...]:
    """Return the groups of the form: first those in `order`, then the others as in the schema.

    Parameters
    ----------
    values
        Setting -> value, or invalid text to show again. The others show their defaults.
    errors
        Setting -> sentence shown at the field.
    """
    preset = preset_of(schema, values)
    groups: dict[tuple[bool, str], list[Field]] = {}
    titles = {name: entry["title"] for name, entry in schema["properties"].items()}
    for name, entry in schema["properties"].items():
        default = preset.get(name, entry.get("default"))
        shown = values.get(name, default)
        key = (entry.get("x-role") == "scenario", entry.get("x-group", ""))
        one = _field(
            name,
            entry,
            shown=shown,
            default=default,
            error=errors.get(name, ""),
            condition=_condition(titles, entry.get("x-applies", {})),
        )
        groups.setdefault(key, []).append(one)
    position = {title: index for index, title in enumerate(order)}
    ordered = sorted(groups.items(), key=lambda item: position.get(item[0][1], len(position)))
    return tuple(
        Group(
            title=title,
            scenario=scenario,
            basic=tuple(one for one in members if not one.advanced),
            advanced=tuple(one for one in members if one.advanced),
        )
        for (scenario, title), members in ordered
    )


def read(schema: Schema, form: Mapping[str, str]) -> dict[str, object]:
    """Return the values of a submitted form. Invalid numbers stay text, for the error message.

    Browsers do not submit unchecked boxes: `<name>.there` says that the form had the field.
    """
    values: dict[str, object] = {}
    for name, entry in schema["properties"].items():
        if entry["type"] == "boolean":
            if f"{name}.there" in form or name in form:
                values[name] = form.get(name) in {"on", "true", "1"}
        elif name in form:
            values[name] = _value(entry, form[name].strip())
    return values


def preset_of(schema: Schema, values: Mapping[str, object]) -> Mapping[str, object]:
    """Return the values preset by other settings, such as those of the chosen vehicle."""
    preset: dict[str, object] = {}
    for name, choices in schema.get("x-presets", {}).items():
        preset |= choices.get(str(values.get(name, "")), {})
    return preset


def _condition(titles: Mapping[str, str], applies: Mapping[str, Sequence[str]]) -> str:
    """Return when a setting has an effect, such as "Tracker esm or visp"."""
    return "; ".join(
        f"{titles.get(other, SOLUTION_TITLE)} {' or '.join(values)}"
        for other, values in applies.items()
    )


def _value(entry: Schema, text: str) -> object:
    schema_type = entry["type"]
    if schema_type == "array":
        parts = text.replace(";", ",").replace(",", " ").split()
        return [_number(part) for part in parts]
    if schema_type == "integer":
        return _whole(text)
    return _number(text) if schema_type == "number" else text


def _whole(text: str) -> object:
    try:
        return int(text)
    except ValueError:  # also of more than 4300 digits
        return text


def _number(text: str) -> object:
    try:
        value = float(text)
    except ValueError:
        return text
    return value if math.isfinite(value) else text


def _field(
    name: str, entry: Schema, *, shown: object, default: object, error: str, condition: str
) -> Field:
    numeric = entry["type"] in {"number", "integer"}
    labels = entry.get("x-labels", {})
    return Field(
        name=name,
        title=entry.get("title", name),
        help=entry.get("description", ""),
        unit=entry.get("x-unit", ""),
        type=_type(entry),
        value=text_of(shown),
        default=text_of(default),
        options=tuple((text_of(v), labels.get(v, text_of(v))) for v in entry.get("enum", ())),
        low=entry.get("minimum", entry.get("exclusiveMinimum")) if numeric else None,
        high=entry.get("maximum") if numeric else None,
        step="1" if entry["type"] == "integer" else "any",
        range=range_of(entry),
        tag=entry.get("x-tag", ""),
        source=entry.get("x-source", ""),
        advanced=bool(entry.get("x-advanced")),
        error=error,
        names=tuple(entry.get("x-names", ())),
        applies=entry.get("x-applies", {}),
        condition=condition,
    )


def _type(entry: Schema) -> str:
    if "enum" in entry:
        return "choice"
    types = {"boolean": "checkbox", "number": "number", "integer": "number", "array": "list"}
    return types.get(entry["type"], "text")


def range_of(entry: Schema) -> str:
    """Return the allowed range in words, empty if there is none."""
    if entry["type"] == "array":
        count = f"{entry.get('minItems', 1)} to {entry.get('maxItems', '∞')} numbers"
        inner = range_of({"type": "number", **entry.get("items", {})})
        return f"{count}, {inner}" if inner else count
    low, above, high = (entry.get(k) for k in ("minimum", "exclusiveMinimum", "maximum"))
    start = f"above {_short(above)}" if above is not None else _short(low)
    if high is None:
        return f"from {start}" if low is not None else start
    join = " up to " if above is not None else " to "
    return f"{start}{join}{_short(high)}" if start else f"up to {_short(high)}"


def _short(limit: float | None) -> str:
    return "" if limit is None else f"{limit:.4g}".replace("-", "−")
