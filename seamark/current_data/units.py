"""Units of velocities, by the words that files use, and names of what they measure."""

from __future__ import annotations

import re

PER_M_S = {  # unit -> factor to m/s
    **dict.fromkeys(("m/s", "m s-1", "m s^-1", "m.s-1", "meter/second", "meters/second"), 1.0),
    **dict.fromkeys(("m_s", "ms-1", "metre second-1", "meter second-1", "m s**-1"), 1.0),
    **dict.fromkeys(("cm/s", "cm s-1", "cm.s-1", "cm_s", "cm s^-1"), 0.01),
    **dict.fromkeys(("mm/s", "mm s-1", "mm_s", "mm s^-1"), 0.001),
    **dict.fromkeys(("knot", "knots", "kn", "kt", "kts"), 1852.0 / 3600.0),
}
# What a name means: CF standard names first, then what instruments and models write.
AXES = {
    "east": (
        *("eastward_sea_water_velocity", "sea_water_x_velocity"),
        *("eastward_water_velocity", "barotropic_eastward_sea_water_velocity"),
        *("east", "east_velocity", "velocity_east", "ve", "uo", "u", "ucur", "vel_east"),
    ),
    "north": (
        *("northward_sea_water_velocity", "sea_water_y_velocity"),
        *("northward_water_velocity", "barotropic_northward_sea_water_velocity"),
        *("north", "north_velocity", "velocity_north", "vn", "vo", "v", "vcur", "vel_north"),
    ),
    "up": (
        *("upward_sea_water_velocity", "upward_water_velocity"),
        *("up", "up_velocity", "velocity_up", "vu", "wo", "w", "wcur", "vel_up"),
    ),
    "down": ("downward_sea_water_velocity", "down", "down_velocity"),
    "speed": ("sea_water_speed", "speed", "current_speed", "magnitude"),
    "direction": (  # that the water goes to, clockwise from north
        *("sea_water_velocity_to_direction", "direction_of_sea_water_velocity"),
        *("direction", "current_direction", "dir"),
    ),
    "depth": ("depth", "depth_below_surface", "lev", "deptht", "depthu", "bin_depth"),
    "height": (
        *("height_above_sea_floor", "height", "height_above_bottom", "range"),
        *("distance_from_bottom", "bin_height"),
    ),
    "time": ("time", "datetime", "date_time", "timestamp", "date", "time_counter"),
}
_MEANING = {name: axis for axis, names in AXES.items() for name in names}
_PARENTHESES = re.compile(r"\s*[(\[]([^)\]]{1,20})[)\]]\s*$")
_SUFFIX = re.compile(r"_(cm_s|mm_s|m_s|m|s|deg|knots)$")


def meaning(name: str) -> str:
    """Return what a name means, one of `AXES`; empty if it is none of ours."""
    return _MEANING.get(name.strip().lower().replace(" ", "_"), "")


def column(title: str) -> tuple[str, str]:
    """Return what the title of a column means and its unit, empty if it says none."""
    text, unit = title.strip().strip('"').lower(), ""
    if found := _PARENTHESES.search(text):
        text, unit = text[: found.start()], found[1].strip()
    elif found := _SUFFIX.search(text):
        text, unit = text[: found.start()], found[1]
    return meaning(text), unit


def factor(unit: str) -> float | None:
    """Return what a velocity in a unit is multiplied with to get m/s; None for no unit of it."""
    return PER_M_S.get(unit.strip().lower())
