"""A setting, declared once: default, range, unit, label and help.

The declaration gives the validation of a value, its entry in the JSON Schema that the form is
generated from, and the text of an error message, so they cannot disagree.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from annotated_types import Ge, Gt, Le, MaxLen, MinLen
from pydantic import Field
from pydantic.fields import FieldInfo

from seamark.sim.metrics.score_expression import MAX_LENGTH

Role = Literal["scenario", "solution"]
JSON_TYPES: dict[object, str] = {bool: "boolean", int: "integer", float: "number", str: "string"}


def setting(  # noqa: PLR0913  # one keyword per schema keyword
    default: object,
    *,
    title: str,
    help: str,
    group: str,
    role: Role,
    unit: str = "",
    low: float | None = None,
    above: float | None = None,
    high: float | None = None,
    choices: Mapping[str, str] | None = None,
    tag: str = "",
    source: str = "",
    advanced: bool = False,
    length: tuple[int, int] | None = None,
    names: Sequence[str] | None = None,
    applies: Mapping[str, Sequence[str]] | None = None,
) -> Any:  # pydantic's own Field returns Any, so that it fits every annotation
    """Return one setting.

    Parameters
    ----------
    default
        The benchmark's value; a ranked run uses it for every scenario setting.
    title, help, group, unit
        What the form shows. `help` is a sentence or two.
    role
        "scenario" is the same for all ranked runs, "solution" is what competes.
    low, above, high
        Allowed range, `above` exclusive; of the items if the setting is a list.
    choices : mapping of value -> label
    tag
        Origin of the default: S sourced, D derived, E estimated; `source` names the source or the
        reason.
    length : minimum and maximum number of items of a list
    names
        Names that an expression may use; the setting is then the text of one, which may be empty.
    applies : mapping of another setting -> its values with which this one has an effect
        "controller" stands for the solution of the run, which is no setting.
    """
    extras: dict[str, Any] = {"x-group": group, "x-role": role, "x-advanced": advanced}
    if unit:
        extras["x-unit"] = unit
    if tag:
        extras |= {"x-tag": tag, "x-source": source}
    if choices is not None:
        extras |= {"enum": list(choices), "x-labels": dict(choices)}
    if names is not None:
        extras["x-names"] = list(names)
    if applies is not None:
        extras["x-applies"] = dict(applies)
    bounds: dict[str, Any]
    if names is not None:
        bounds = {"max_length": MAX_LENGTH}
    elif length is None:
        bounds = {"ge": low, "gt": above, "le": high}
    else:
        items = {"minimum": low, "exclusiveMinimum": above, "maximum": high}
        extras["x-items"] = {name: value for name, value in items.items() if value is not None}
        bounds = {"min_length": length[0], "max_length": length[1]}
    return Field(
        default,
        title=title,
        description=help,
        json_schema_extra=extras,
        validate_default=True,
        **bounds,
    )


def override(
    inherited: FieldInfo,
    default: object,
    *,
    help: str | None = None,
    **changes: str,
) -> Any:  # as `setting`
    """Return an inherited setting with another default and, if given, another text.

    Parameters
    ----------
    help
        What the form shows, if it differs.
    changes
        Group, tag, source or role, as in `setting`.
    """
    extras = schema_extras(inherited) | {f"x-{word}": value for word, value in changes.items()}
    description = help or inherited.description
    return FieldInfo.merge_field_infos(
        inherited, default=default, description=description, json_schema_extra=extras
    )


def schema_extras(field: FieldInfo) -> dict[str, Any]:
    """Return the keywords of a setting that pydantic does not know, such as x-group."""
    extras = field.json_schema_extra
    return dict(extras) if isinstance(extras, dict) else {}


def group_of(field: FieldInfo) -> str:
    """Return the group of a setting."""
    return str(schema_extras(field)["x-group"])


def limits_of(field: FieldInfo) -> dict[str, Any]:
    """Return the limits of a setting by their JSON Schema keyword."""
    limits: dict[str, Any] = {}
    for constraint in field.metadata:
        match constraint:
            case Ge(ge=limit):
                limits["minimum"] = limit
            case Gt(gt=limit):
                limits["exclusiveMinimum"] = limit
            case Le(le=limit):
                limits["maximum"] = limit
            case MinLen(min_length=length):
                limits["minLength"] = length
            case MaxLen(max_length=length):
                limits["maxLength"] = length
    return limits


def allowed_values(field: FieldInfo) -> str:
    """Return the allowed values of a setting in words, such as "a number from 0 to 10 1/s"."""
    extras = schema_extras(field)
    if "enum" in extras:
        return "one of " + ", ".join(extras["enum"])
    if field.annotation is bool:
        return "true or false"
    if "x-names" in extras:
        return f"a text of at most {MAX_LENGTH} characters"
    unit = f" {extras['x-unit']}" if "x-unit" in extras else ""
    limits = limits_of(field)
    items = extras.get("x-items")
    if items is not None:
        low, high = limits["minLength"], limits["maxLength"]
        count = f"{low}" if low == high else f"{low} to {high}"
        return f"a list of {count} numbers {_range(items, unit)}"
    number = "a whole number" if field.annotation is int else "a number"
    return f"{number} {_range(limits, unit)}".strip()


def _range(limits: Mapping[str, float], unit: str) -> str:
    low, above, high = (limits.get(k) for k in ("minimum", "exclusiveMinimum", "maximum"))
    start = f"above {above:g}" if above is not None else f"from {low:g}" if low is not None else ""
    if high is None:
        return f"{start}{unit}"
    return f"{start} to {high:g}{unit}" if low is not None else f"{start} up to {high:g}{unit}"


def is_outside(value: object, field: FieldInfo) -> bool:
    """Return whether a choice, or an item of a list, is not one of the allowed ones."""
    extras = schema_extras(field)
    if "enum" in extras:
        return value not in extras["enum"]
    if "x-items" in extras and isinstance(value, tuple):
        return not all(_is_inside(item, extras["x-items"]) for item in value)
    return False


def _is_inside(item: float, limits: Mapping[str, float]) -> bool:
    return (
        math.isfinite(item)
        and item >= limits.get("minimum", -math.inf)
        and item > limits.get("exclusiveMinimum", -math.inf)
        and item <= limits.get("maximum", math.inf)
    )


def property_of(name: str, field: FieldInfo) -> dict[str, Any]:
    """Return the entry of a setting in the JSON Schema."""
    extras = schema_extras(field)
    default = field.default
    entry: dict[str, Any] = {"title": field.title or name, "description": field.description or ""}
    entry["default"] = list(default) if isinstance(default, tuple) else default
    limits = limits_of(field)
    items = extras.pop("x-items", None)
    if items is not None:
        entry |= {"type": "array", "items": {"type": "number"} | items}
        entry["minItems"] = limits["minLength"]
        entry["maxItems"] = limits["maxLength"]
    else:
        entry |= {"type": JSON_TYPES[field.annotation]} | limits
    return entry | extras
