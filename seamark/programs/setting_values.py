"""Values of the settings of a run, by the JSON Schema of its benchmark."""

from collections.abc import Collection, Mapping
from typing import Any

from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.settings.position_controllers import UPLOAD

Schema = Mapping[str, Any]
SOLUTION = "controller"  # the name under which conditions know the solution; also a role


def in_effect(
    benchmark: Benchmark,
    config: Mapping[str, object],
    solution: str,
    *,
    parts: Collection[str] = (),
) -> dict[str, Schema]:
    """Return name -> schema of the settings that have any effect in a run, in their order.

    Parameters
    ----------
    solution
        The name of a built-in solution, or UPLOAD.
    parts
        Roles of further programs: each replaces what the setting with its name chooses.
    """
    chosen = {**config, SOLUTION: solution}
    for role in parts:
        chosen.pop(role, None)
    if benchmark.role != SOLUTION and solution == UPLOAD:
        # It replaces the built-in tracker or detector, which the setting with the name of the role
        # chooses, with all options of that one.
        chosen.pop(benchmark.role, None)
    properties: Mapping[str, Schema] = benchmark.schema()["properties"]
    return {
        name: entry
        for name, entry in properties.items()
        if name in chosen and is_applicable(entry, chosen)
    }


def is_applicable(entry: Schema, values: Mapping[str, object]) -> bool:
    """Return whether a setting has any effect with these values of other settings."""
    conditions: Mapping[str, list[str]] = entry.get("x-applies", {})
    return all(str(values.get(other)) in allowed for other, allowed in conditions.items())


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


def differences(benchmark: Benchmark, values: Mapping[str, object]) -> list[tuple[str, str, str]]:
    """Return title, unit and value, for readers, of the settings that differ from the defaults."""
    properties: Mapping[str, Schema] = benchmark.schema()["properties"]
    return [
        (
            properties[name]["title"],
            properties[name].get("x-unit", ""),
            label_of(properties[name], value),
        )
        for name, value in values.items()
        if value != properties[name].get("default")
    ]
