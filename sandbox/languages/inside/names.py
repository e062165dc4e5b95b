"""The numbers of an observation and of a command by the names that models give to their ports.

A vector is there as a whole (`error`), by its elements as Modelica and Simulink count them
(`error[1]`), with the number at its end (`error_1`), and by the names of its axes (`error_x`).
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

AXES: dict[str, Sequence[str]] = {
    "error": ("error_x", "error_y", "error_z"),
    "error_px": ("error_px_x", "error_px_y"),
    "velocity": ("velocity_x", "velocity_y", "velocity_z"),
    "attitude": ("roll", "pitch", "yaw"),
    "rates": ("p", "q", "r"),
}
COMMAND = ("surge", "sway", "heave", "yaw_rate")
WHOLE_COMMAND = "command"  # all four in one vector


class Place(NamedTuple):
    """Where a name's numbers stand in an observation or a command."""

    offset: int
    size: int


def observed(layout: dict[str, Any]) -> dict[str, Place]:
    """Return the place of each name in an observation of this layout."""
    places: dict[str, Place] = {}
    offset = 0
    for name, count in layout["observation"]:
        places.update(_named(name, offset, count, AXES.get(name, ())))
        offset += count or 1
    return places


def commanded() -> dict[str, Place]:
    """Return the place of each name in a command."""
    return _named(WHOLE_COMMAND, 0, len(COMMAND), COMMAND)


def shown(layout: dict[str, Any]) -> str:
    """Return the names of an observation as a person wants to read them: one for each number."""
    words: list[str] = []
    for name, count in layout["observation"]:
        words += AXES.get(name) or [f"{name}[{i + 1}]" for i in range(count)] or [name]
    return ", ".join(words)


def _named(name: str, offset: int, count: int, axes: Sequence[str]) -> dict[str, Place]:
    places = {name: Place(offset, count or 1)}
    for index in range(count):
        for element in (f"{name}[{index + 1}]", f"{name}_{index + 1}", *axes[index : index + 1]):
            places[element] = Place(offset + index, 1)
    return places
