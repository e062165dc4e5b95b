"""The mapping of a log: what its columns or topics are, in which frame and in which units.

A TOML or JSON document. A log with the columns of Seamark's own telemetry needs none.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from annotated_types import Ge, Gt, Le, Len
from pydantic import BaseModel, ConfigDict, ValidationError, field_validator, model_validator

from seamark.mission_logs.result import LogRefused
from seamark.sim.recording import telemetry
from seamark.sim.vehicles.reading import THRUSTERS_MAX

TEXT_MAX = 16 * 1024  # [character] of a document
NAME_MAX = 200  # [character] of a column, a topic or a field
QUATERNION: tuple[str, ...] = ("qx", "qy", "qz", "qw")
TRUE_CORNERS: tuple[str, ...] = tuple(f"true_corner_{i}" for i in range(8))
CORNERS: tuple[str, ...] = tuple(f"corner_{i}" for i in range(8))
# unit -> what it measures, and how much of the telemetry's unit it is
UNITS: Mapping[str, tuple[str, float]] = {
    "": ("", 1.0),
    **{"m": ("m", 1.0), "cm": ("m", 1e-2), "mm": ("m", 1e-3)},
    **{"rad": ("rad", 1.0), "deg": ("rad", 0.017453292519943295)},
    **{"s": ("s", 1.0), "ms": ("s", 1e-3), "us": ("s", 1e-6), "ns": ("s", 1e-9)},
    **{"m/s": ("m/s", 1.0), "cm/s": ("m/s", 1e-2), "kn": ("m/s", 1852.0 / 3600.0)},
    **{"rad/s": ("rad/s", 1.0), "deg/s": ("rad/s", 0.017453292519943295)},
    **{"px": ("px", 1.0), "N": ("N", 1.0), "N m": ("N m", 1.0)},
}
WRENCH: tuple[str, ...] = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
_EXTRA_UNITS = {  # what is no column of the telemetry, or not of every vehicle
    **dict.fromkeys(QUATERNION, ""),
    **dict.fromkeys(TRUE_CORNERS, "px"),
    **dict.fromkeys(telemetry.thrust_names(THRUSTERS_MAX), "N"),
    **dict.fromkeys(telemetry.numbered("command", THRUSTERS_MAX), ""),
    **dict.fromkeys(WRENCH[:3], "N"),
    **dict.fromkeys(WRENCH[3:], "N m"),
}
KNOWN: Mapping[str, str] = {  # what a mapping may name -> its unit in the telemetry
    column.name: column.unit for column in telemetry.COLUMNS if column.name != "step_us"
} | _EXTRA_UNITS

Name = Annotated[str, Len(1, NAME_MAX)]
Coordinate = Annotated[float, Ge(-1e6), Le(1e6)]  # [m]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Source(_Part):
    """A column or a field of the log, and its unit; empty: the unit of the telemetry."""

    name: Name
    unit: str = ""

    @model_validator(mode="before")
    @classmethod
    def _from_name(cls, value: object) -> object:
        return {"name": value} if isinstance(value, str) else value

    @field_validator("unit")
    @classmethod
    def _known(cls, unit: str) -> str:
        if unit not in UNITS:
            raise ValueError(f"the unit {unit!r} is none of {', '.join(filter(None, UNITS))}")
        return unit


class Time(_Part):
    """How the log tells the time.

    Without `period_s`, the rows of the log are the control steps, at regular intervals. With it,
    each control step has the newest values that are not older than `max_gap_s`.
    """

    period_s: Annotated[float, Ge(0.01), Le(0.5)] | None = None
    max_gap_s: Annotated[float, Gt(0.0), Le(10.0)] | None = None


class Topics(_Part):
    """The topics of a bag, by what their messages are."""

    pose: Name | None = None
    velocity: Name | None = None
    corners: Name | None = None
    true_corners: Name | None = None


class TargetPose(_Part):
    """Where the centre of the target's top face is in the log's world frame.

    `heading` [rad] is that of the vehicle from which one reads the target upright.
    """

    position: tuple[Coordinate, Coordinate, Coordinate]
    heading: Annotated[float, Ge(-7.0), Le(7.0)] = 0.0


class LogMapping(_Part):
    """What a log means. Every part has a default: that of Seamark's own telemetry."""

    benchmark: Name | None = None
    frame: Literal["NED", "ENU"] | None = None  # what the log says, else NED
    time: Time = Time()
    columns: Annotated[dict[Name, Source], Len(0, 100)] = {}
    topics: Topics = Topics()
    target: TargetPose | None = None
    settings: Annotated[dict[Name, Any], Len(0, 100)] = {}

    @field_validator("columns")
    @classmethod
    def _known_columns(cls, columns: dict[str, Source]) -> dict[str, Source]:
        for name, source in columns.items():
            if name not in KNOWN:
                raise ValueError(f"{name} is no column of the telemetry")
            kind, _ = UNITS[source.unit]
            if source.unit and kind != KNOWN[name]:
                raise ValueError(f"{name} is in {KNOWN[name] or 'no unit'}, not in {source.unit}")
        return columns

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the mapping of a TOML or JSON document.

        Raises
        ------
        LogRefused
            It is too long, neither of both, or breaks a rule.
        """
        if len(text) > TEXT_MAX:
            raise LogRefused(f"The mapping is longer than {TEXT_MAX} characters.")
        try:
            if text.lstrip().startswith("{"):
                return cls.model_validate(json.loads(text))
            return cls.model_validate(tomllib.loads(text))
        except ValidationError as error:
            raise LogRefused(_sentences(error)) from None
        except (ValueError, RecursionError) as error:
            raise LogRefused(f"The mapping is neither TOML nor JSON: {error}.") from None


def factor(column: str, source: Source) -> float:
    """Return by what the values of a source are multiplied for the telemetry."""
    return UNITS[source.unit or KNOWN[column]][1]


def _sentences(error: ValidationError) -> str:
    """Return the first faults of a mapping, each with its key."""
    sentences = []
    for one in error.errors(include_url=False)[:5]:
        key = ".".join(map(str, one["loc"])) or "document"
        sentences.append(f"{key}: {one['msg'].removeprefix('Value error, ')}")
    return f"The mapping is wrong. {'; '.join(sentences)}."
