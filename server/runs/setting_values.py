"""Values of the settings of a run, by the JSON Schema of its benchmark."""

from collections.abc import Mapping
from typing import Any

Schema = Mapping[str, Any]
SOLUTION = "controller"  # the name under which conditions know the solution


def is_applicable(entry: Schema, values: Mapping[str, object]) -> bool:
    """Return whether a setting has any effect with these values of other settings.

    `values` may have the name of the solution under SOLUTION.
    """
    return all(
        str(values.get(other)) in allowed for other, allowed in entry.get("x-applies", {}).items()
    )


def text_of(value: object) -> str:
    """Return the text of a value in a field."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return ", ".join(text_of(item) for item in value)
    if isinstance(value, float) and value == int(value) and abs(value) < 1e15:
        return str(int(value))
    return str(value)


def label_of(entry: Schema, value: object) -> str:
    """Return the text of a value for readers: its label if it is one of named choices."""
    labels = {"true": "yes", "false": "no"} if entry["type"] == "boolean" else {}
    text = text_of(value)
    label: str = (entry.get("x-labels") or labels).get(text, text)
    return label
