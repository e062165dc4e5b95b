"""Writes the file of a vehicle with what was fitted; all else in it stays as it was."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

from seamark.identification.identified import Identified, Parameter
from seamark.identification.parameters import KINDS
from seamark.sim.vehicles import AXES, Vehicle, load
from seamark.sim.vehicles.reading import FORMAT, VehicleInvalid, read_vehicle
from seamark.sim.vehicles.toml_reading import read_toml, without_texts

SOURCE, KEPT = "identified", "kept"  # names in [sources]
_HEADER = re.compile(r"\s*\[\s*([A-Za-z0-9_-]+)\s*\]\s*(#.*)?$")
_DIGITS = 6  # significant ones


class FileNotEdited(Exception):
    """The file is written in a way that is not edited. The text is for the user."""


def extending(vehicle: Vehicle) -> str:
    """Return a file that is one of Seamark's vehicles under another name."""
    return "\n".join(
        [
            f"format = {FORMAT}",
            f'name = "{vehicle.name}-identified"',
            f"title = {_value(f'{vehicle.title}, identified')}",
            f"summary = {_value(vehicle.summary)}",
            f'extends = "{vehicle.name}"',
            "",
        ]
    )


def fitted_file(text: str, vehicle: Vehicle, identified: Identified, *, source: str) -> str:
    """Return the text of a vehicle's file with the fitted numbers and their intervals.

    Parameters
    ----------
    text
        The file that `vehicle` was read from.
    source
        What the numbers are from, for [sources].

    Raises
    ------
    FileNotEdited
        Its [body] is not written as a table with lists.
    """
    body: Mapping[str, Any] = read_toml(text.encode()).get("body", {})
    text = _set(text, "sources", SOURCE, _value(source))
    if any(key not in body for key in KINDS):
        text = _set(text, "sources", KEPT, _value(f"as in {vehicle.title}"))
    for at, key in enumerate(KINDS):
        own = identified.parameters[at * len(AXES) : (at + 1) * len(AXES)]
        groups = _given(body[key]) if key in body else _inherited(getattr(vehicle, key))
        lines = [_line(group, one) for group, one in zip(groups, own, strict=True)]
        text = _set(text, "body", key, "\n".join(["[", *lines, "]"]))
    try:
        read_vehicle(text.encode(), base=load)
    except VehicleInvalid as invalid:
        raise FileNotEdited(
            "The fitted numbers do not fit into the file. Write added_mass, drag_linear and "
            f"drag_quadratic as lists below a line [body], as docs/vehicles.md does. {invalid}"
        ) from None
    return text


def _given(groups: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the groups of a file, one for each axis."""
    single = []
    for group in groups:
        for at, axis in enumerate(group["axes"]):
            one = {**group, "axes": [axis], "value": [group["value"][at]]}
            if "spread" in group:
                one["spread"] = [[limit[at]] for limit in group["spread"]]
            single.append(one)
    return single


def _inherited(groups: Sequence[Any]) -> list[dict[str, Any]]:
    """Return the groups of the vehicle that a file extends, one for each axis."""
    values = [(group, value) for group in groups for value in group.value]
    return [
        {
            "axes": [axis],
            "value": [value],
            "unit": group.unit,
            "tag": group.tag,
            "source": KEPT,
        }
        for axis, (group, value) in zip(AXES, values, strict=True)
    ]


def _line(group: Mapping[str, Any], fitted: Parameter) -> str:
    """Return the group of one axis as a line: fitted, or as it was."""
    if fitted.margin is None and fitted.below is None:
        return f"  {_inline(group)},"
    if fitted.margin is None and fitted.below is not None:
        low, high = fitted.below
        said = f"without a bound at 0 the 95 % interval is {low:.4g} to {high:.4g}"
    else:
        low, high = fitted.interval or (0.0, 0.0)
        said = f"95 % interval {low:.4g} to {high:.4g}"
    said = f"{said}, before {fitted.before:.4g}"
    made = {
        "axes": group["axes"],
        "value": [float(f"{fitted.value:.{_DIGITS}g}")],
        "unit": group["unit"],
        "tag": "M",
        "source": SOURCE,
        "reason": said,
    }
    return f"  {_inline(made)},"


def _inline(table: Mapping[str, Any]) -> str:
    return "{ " + ", ".join(f"{key} = {_value(value)}" for key, value in table.items()) + " }"


def _value(value: object) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def _set(text: str, section: str, key: str, value: str) -> str:
    """Return a document in which a key of a top-level table has a value."""
    lines = text.split("\n")
    begin, end = _section(lines, section)
    if begin is None:
        return text.rstrip("\n") + f"\n\n[{section}]\n{key} = {value}\n"
    at = begin + 1
    while at < end:
        after = _end_of_value(lines, at)
        if without_texts(lines[at]).partition("=")[0].strip() == key:
            return "\n".join([*lines[:at], f"{key} = {value}", *lines[after:]])
        at = after
    return "\n".join([*lines[: begin + 1], f"{key} = {value}", *lines[begin + 1 :]])


def _section(lines: Sequence[str], section: str) -> tuple[int | None, int]:
    """Return the line of a table's header and the line after the table."""
    begin, at = None, 0
    while at < len(lines):
        if begin is not None and without_texts(lines[at]).lstrip().startswith("["):
            return begin, at
        header = _HEADER.fullmatch(lines[at])
        if header and header[1] == section:
            begin = at
            at += 1
        elif header:
            at += 1
        else:
            at = _end_of_value(lines, at)
    return begin, len(lines)


def _end_of_value(lines: Sequence[str], at: int) -> int:
    """Return the line after a value that begins in a line: brackets may close later."""
    nesting = 0
    while at < len(lines):
        bare = without_texts(lines[at])
        nesting += sum(bare.count(one) for one in "[{") - sum(bare.count(one) for one in "]}")
        at += 1
        if nesting <= 0:
            break
    return at
