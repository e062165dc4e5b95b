"""The names by which models connect to the numbers of an observation and of a command.

A vector has a name as a whole (`error`); its elements have the index of Modelica and Simulink
(`error[1]`), the index as a suffix (`error_1`), and the name of their axis (`error_x`).
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
WHOLE_COMMAND = "command"  # all in one vector


class Span(NamedTuple):
    """Which numbers of an observation or a command a name stands for."""

    offset: int
    size: int


def observation_spans(layout: dict[str, Any]) -> dict[str, Span]:
    """Return the numbers of each name in an observation of this layout."""
    spans: dict[str, Span] = {}
    offset = 0
    for name, count in layout["observation"]:
        spans.update(_named(name, offset, count, AXES.get(name, ())))
        offset += count or 1
    return spans


def command_spans(names: Sequence[str]) -> dict[str, Span]:
    """Return the numbers of each name in a command with these names."""
    return _named(WHOLE_COMMAND, 0, len(names), names)


def observation_names(layout: dict[str, Any]) -> str:
    """Return the names of an observation for a person to read: one for each number."""
    words: list[str] = []
    for name, count in layout["observation"]:
        words += AXES.get(name) or [f"{name}[{i + 1}]" for i in range(count)] or [name]
    return ", ".join(words)


def _named(name: str, offset: int, count: int, axes: Sequence[str]) -> dict[str, Span]:
    spans = {name: Span(offset, count or 1)}
    for index in range(count):
        for element in (f"{name}[{index + 1}]", f"{name}_{index + 1}", *axes[index : index + 1]):
            spans[element] = Span(offset + index, 1)
    return spans
