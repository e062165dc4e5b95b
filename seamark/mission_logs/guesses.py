"""What a log says without a mapping: guessed from the usual names, and told to whoever opened it.

A column of Seamark's own name and what a mapping says are never guessed.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from seamark.mission_logs.mapping import CORNERS, KNOWN, QUATERNION, UNITS, Source

Frame = Literal["NED", "ENU"]
ANGLES: tuple[str, ...] = ("roll", "pitch", "yaw")
_NORTH = ("north", "northing", "pos_n", "pos_north", "position_north")
_EAST = ("east", "easting", "pos_e", "pos_east", "position_east")
_DOWN = ("down", "depth", "pos_d", "pos_down", "position_down")
_UP = ("up", "pos_u", "pos_up", "position_up")
_WORLD: Mapping[Frame, Mapping[str, Sequence[str]]] = {
    "NED": {"x": _NORTH, "y": _EAST, "z": _DOWN},
    "ENU": {"x": _EAST, "y": _NORTH, "z": _UP},
}
_TIMES = (
    *("time", "timestamp", "stamp", "datetime", "date_time", "utc", "time_utc", "utc_time"),
    *("timestamp_utc", "unix_time", "epoch", "elapsed", "elapsed_time", "seconds", "secs"),
)
_OTHERS: Mapping[str, Sequence[str]] = {
    "t": _TIMES,
    "roll": ("phi", "roll_angle"),
    "pitch": ("theta", "pitch_angle"),
    "yaw": ("heading", "hdg", "psi", "compass", "yaw_angle"),
    **{f"q{axis}": (f"q_{axis}", f"quat_{axis}", f"orientation_{axis}") for axis in "xyzw"},
    **{"u": ("surge", "surge_velocity"), "v": ("sway", "sway_velocity")},
    **{"w": ("heave", "heave_velocity"), "p": ("roll_rate",), "q": ("pitch_rate",)},
    "r": ("yaw_rate",),
    **{
        name: (f"corner{at // 2}_{'xy'[at % 2]}", f"corner_{at // 2}_{'xy'[at % 2]}")
        for at, name in enumerate(CORNERS)
    },
}
_IN_DEGREES = ("heading", "hdg", "compass")  # unless their name says rad
_ENDINGS = ("orientation_", "position_")  # as of field.pose.pose.position.x
_SUFFIXES: Mapping[str, str] = {  # how a name ends -> unit
    **{f"_{unit}": unit for unit in UNITS if unit.isalpha()},
    **{"_m_s": "m/s", "_mps": "m/s", "_cm_s": "cm/s", "_rad_s": "rad/s", "_deg_s": "deg/s"},
    **{"_degrees": "deg", "_degree": "deg", "_meters": "m", "_metres": "m", "_sec": "s"},
}
_BRACKETED = re.compile(r"^(?P<name>.*?)\s*[\[(](?P<unit>[^\])]*)[\])]\s*$")
_APART = re.compile(r"[^a-z0-9]+")


@dataclass(frozen=True)
class Guesses:
    """What was guessed of a log."""

    columns: Mapping[str, Source] = field(default_factory=dict)  # column of the telemetry -> source
    topics: Mapping[str, str] = field(default_factory=dict)  # role -> topic
    frame: Frame | None = None

    def document(self) -> dict[str, Any]:
        """Return them in the form of a mapping."""
        columns = {name: source.model_dump() for name, source in self.columns.items()}
        parts = {"frame": self.frame, "topics": dict(self.topics), "columns": columns}
        return {name: value for name, value in parts.items() if value}


def guess_columns(names: Sequence[str], taken: Collection[str], frame: Frame) -> dict[str, Source]:
    """Return columns of the telemetry that have a usual name in a file.

    Parameters
    ----------
    names
        Of the file's columns.
    taken
        Columns of the telemetry that are known already.
    """
    sources: dict[str, Source] = {}
    for column, aliases in _aliases(frame).items():
        source = None if column in taken else _source(column, aliases, names)
        if source is not None:
            sources[column] = source
    turned = set(QUATERNION) <= {*sources, *taken}
    for name in ANGLES if turned else QUATERNION:  # one of both, and a quaternion only as a whole
        sources.pop(name, None)
    return sources


def _aliases(frame: Frame) -> Mapping[str, Sequence[str]]:
    positions = {
        name: (name, *aliases, f"pos_{name}", f"position_{name}")
        for name, aliases in _WORLD[frame].items()
    }
    return positions | {name: (name, *aliases) for name, aliases in _OTHERS.items()}


def _source(column: str, aliases: Sequence[str], names: Sequence[str]) -> Source | None:
    """Return the first column of the file that has one of these names, and its unit."""
    split = [(name, *_split(name, KNOWN[column])) for name in names]
    for alias in aliases:
        for name, plain, unit in split:
            if names.count(name) == 1 and _is(plain, alias):
                default = "deg" if alias in _IN_DEGREES else ""
                return Source(name=name, unit=unit or default)
    return None


def _is(plain: str, alias: str) -> bool:
    return plain == alias or (alias.startswith(_ENDINGS) and plain.endswith(f"_{alias}"))


def _split(name: str, kind: str) -> tuple[str, str]:
    """Return a name without its unit, and the unit; empty if it has none of this kind."""
    bracketed = _BRACKETED.match(name[:200])
    if bracketed and UNITS.get(bracketed["unit"], ("?", 0.0))[0] == kind:
        return _plain(bracketed["name"]), bracketed["unit"]
    plain = _plain(name)
    for suffix, unit in sorted(_SUFFIXES.items(), key=lambda one: -len(one[0])):
        if plain.endswith(suffix) and UNITS[unit][0] == kind:
            return plain.removesuffix(suffix), unit
    return plain, ""


def _plain(name: str) -> str:
    return _APART.sub("_", name.lower()).strip("_")
