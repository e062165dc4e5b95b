"""Currents in NetCDF: by the standard names of CF, or as DOLfYN and MHKiT lay out an ADCP's.

Version 3 is read by SciPy, version 4 by h5netcdf (the extra `netcdf`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.current_data.series import VALUES_MAX, CurrentRefused, Series
from seamark.current_data.units import factor, meaning

Array = NDArray[np.float64]
SUFFIXES = (".nc", ".nc4", ".cdf", ".netcdf")
VARIABLES_MAX = 2000
_SINCE = re.compile(r"(\w+) since (.{4,40})", re.IGNORECASE)
_SECONDS = {
    **dict.fromkeys(("second", "seconds", "s", "sec", "secs"), 1.0),
    **dict.fromkeys(("minute", "minutes", "min", "mins"), 60.0),
    **dict.fromkeys(("hour", "hours", "h", "hr", "hrs"), 3600.0),
    **dict.fromkeys(("day", "days", "d"), 86400.0),
    **dict.fromkeys(("millisecond", "milliseconds", "ms", "msec"), 1e-3),
    **dict.fromkeys(("microsecond", "microseconds", "us"), 1e-6),
    **dict.fromkeys(("nanosecond", "nanoseconds", "ns"), 1e-9),
}
_CALENDARS = frozenset(("", "standard", "gregorian", "proleptic_gregorian"))
_EARTH = ("e", "n", "u")  # DOLfYN's names of axes; a fourth one is a second vertical velocity


@dataclass(frozen=True, slots=True)
class _Variable:
    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    attributes: Mapping[str, Any]
    raw: Any

    def text(self, name: str) -> str:
        """Return an attribute as text."""
        value = self.attributes.get(name, "")
        return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)

    def values(self) -> Array:
        """Return the numbers, unpacked, with NaN where they are missing."""
        if int(np.prod(self.shape, dtype=np.float64)) > VALUES_MAX:
            raise CurrentRefused(f"{self.name} has more than {VALUES_MAX} numbers.")
        given = np.array(self.raw[...] if self.shape else self.raw[()])
        if given.dtype.kind not in "fiu":
            raise CurrentRefused(f"{self.name} does not consist of numbers.")
        out = given.astype(np.float64)
        for name in ("_FillValue", "missing_value"):
            for value in np.atleast_1d(self.attributes.get(name, ())):
                out[given == value] = np.nan
        scale, offset = (self.attributes.get(name) for name in ("scale_factor", "add_offset"))
        out = out * float(np.ravel(scale)[0]) if scale is not None else out
        return out + float(np.ravel(offset)[0]) if offset is not None else out


def read_netcdf(path: Path) -> Series:
    """Return the currents of a file; raises CurrentRefused."""
    try:
        with _opened(path) as variables:
            if "vel" in variables and len(variables["vel"].dims) == 3:
                return _dolfyn(variables)
            return _cf(variables)
    except CurrentRefused:
        raise
    except MemoryError:
        raise CurrentRefused("The file claims to have more data than fit in memory.") from None
    except (OSError, ValueError, TypeError, KeyError, IndexError, RuntimeError) as error:
        # The libraries raise all of them at damaged files.
        raise CurrentRefused(f"The file cannot be read as NetCDF: {error}") from None


@contextmanager
def _opened(path: Path) -> Iterator[dict[str, _Variable]]:
    with path.open("rb") as file:
        start = file.read(4)
    if start[:3] == b"CDF":
        from scipy.io import netcdf_file

        with netcdf_file(path, "r", mmap=False) as opened:
            yield _limited(
                _Variable(name, tuple(v.dimensions), tuple(v.shape), dict(v._attributes), v.data)
                for name, v in opened.variables.items()
            )
        return
    if start != b"\x89HDF":
        raise CurrentRefused("The file is no NetCDF: it has neither its beginning nor HDF5's.")
    if find_spec("h5netcdf") is None:
        raise CurrentRefused('NetCDF 4 needs the extra `netcdf`: pip install "seamark[netcdf]".')
    import h5netcdf

    with h5netcdf.File(path, "r") as opened:
        yield _limited(
            _Variable(name, tuple(v.dimensions), tuple(v.shape), dict(v.attrs), v)
            for name, v in opened.variables.items()
        )


def _limited(variables: Iterator[_Variable]) -> dict[str, _Variable]:
    out: dict[str, _Variable] = {}
    for variable in variables:
        if len(out) >= VARIABLES_MAX:
            raise CurrentRefused(f"The file has more than {VARIABLES_MAX} variables.")
        out[variable.name] = variable
    return out


def _cf(variables: Mapping[str, _Variable]) -> Series:
    """Return currents of variables with CF's standard names, or with the usual short ones."""
    found: dict[str, _Variable] = {}
    for by_name in (False, True):
        for variable in variables.values():
            word = variable.name if by_name else variable.text("standard_name")
            axis = meaning(word)
            if axis and axis not in found:
                found[axis] = variable
    if not {"east", "north"} <= found.keys():
        raise CurrentRefused(
            "The file has no variables eastward_sea_water_velocity and "
            "northward_sea_water_velocity: neither by the attribute standard_name nor by a name."
        )
    times, begins, time_dim = _times(variables, found["east"].dims)
    level, levels, level_dim = _levels(variables, found, found["east"].dims, time_dim)
    parts, said = [], []
    for axis in ("north", "east"):
        parts.append(_placed(found[axis], time_dim, level_dim))
    if "up" in found:
        parts.append(-_placed(found["up"], time_dim, level_dim))
    else:
        parts.append(np.zeros_like(parts[0]))
        said.append("There is no upward velocity: it is zero.")
    if not level_dim:
        said.append("There is no dimension of depth: one level.")
    velocity = np.stack(parts, axis=1)
    return Series(times, levels, velocity, level == "depth", "NetCDF, CF", begins, tuple(said))


def _dolfyn(variables: Mapping[str, _Variable]) -> Series:
    """Return the currents of `vel` (dir, range, time), in earth's axes."""
    vel = variables["vel"]
    axes = [str(_as_text(one)).lower() for one in np.ravel(variables["dir"].raw[...])[:4]]
    if [one[0] for one in axes[:3]] != list(_EARTH) or vel.dims[2][:4] != "time":
        raise CurrentRefused(
            f"`vel` must have the axes E, N, U and then range and time, not {', '.join(axes)}: "
            "turn it with dolfyn.rotate2(dataset, 'earth')."
        )
    times, begins, _dim = _times(variables, vel.dims)
    heights = variables[vel.dims[1]].values()
    values = vel.values()
    scale = _scale(vel)
    velocity = scale * np.stack([values[1], values[0], -values[2]], axis=1)
    said = ("`range` was taken for the height above the bottom: an instrument that lies on it.",)
    return Series(times, heights, velocity, False, "NetCDF, DOLfYN's", begins, said)


def _as_text(value: object) -> object:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def _scale(variable: _Variable) -> float:
    unit = variable.text("units")
    scale = factor(unit) if unit else 1.0
    if scale is None:
        raise CurrentRefused(f"The unit of {variable.name}, {unit}, is none of a velocity.")
    return scale


def _times(variables: Mapping[str, _Variable], dims: Sequence[str]) -> tuple[Array, str, str]:
    """Return the instants [s], the first of them as a date, and their dimension."""
    for variable in variables.values():
        found = _SINCE.match(variable.text("units"))
        if not found or len(variable.dims) != 1 or variable.dims[0] not in dims:
            continue
        length = _SECONDS.get(found[1].lower())
        if length is None or variable.text("calendar").lower() not in _CALENDARS:
            raise CurrentRefused(f"The time's unit or calendar is not known: {found[0]}.")
        given = variable.values()
        if not np.all(np.isfinite(given)):
            raise CurrentRefused("An instant is missing.")
        # From the first on, so that large numbers do not cost the fraction of a second.
        times = (given - given[0]) * length
        return times, _date(found[2], float(given[0]) * length), variable.dims[0]
    raise CurrentRefused("The file has no time: no variable in units of `seconds since` a date.")


def _date(reference: str, since_s: float) -> str:
    try:
        moment = datetime.fromisoformat(reference.strip().replace(" UTC", "+00:00"))
        moment = moment if moment.tzinfo else moment.replace(tzinfo=UTC)
        return (moment + timedelta(seconds=since_s)).isoformat(timespec="seconds")
    except (ValueError, OverflowError):
        return ""  # only told


def _levels(
    variables: Mapping[str, _Variable],
    found: Mapping[str, _Variable],
    dims: Sequence[str],
    time_dim: str,
) -> tuple[str, Array, str]:
    """Return whether levels are depths or heights, the levels [m], and their dimension."""
    for axis in ("height", "depth"):
        variable = found.get(axis)
        if variable is None or len(variable.dims) != 1 or variable.dims[0] not in dims:
            continue
        if variable.dims[0] == time_dim:
            continue
        levels = variable.values()
        upward = variable.text("positive").lower() == "up"
        return axis, -levels if axis == "depth" and upward else levels, variable.dims[0]
    return "height", np.ones(1), ""


def _placed(variable: _Variable, time_dim: str, level_dim: str) -> Array:
    """Return (h, n) [m/s] of a variable whose other dimensions have a length of one."""
    values = _scale(variable) * variable.values()
    for at in reversed(range(len(variable.dims))):
        name = variable.dims[at]
        if name in (time_dim, level_dim):
            continue
        if variable.shape[at] != 1:
            raise CurrentRefused(
                f"{variable.name} has {variable.shape[at]} points along {name}: cut out one place "
                "first."
            )
        values = np.take(values, 0, axis=at)
    kept = [name for name in variable.dims if name in (time_dim, level_dim)]
    if time_dim not in kept:
        raise CurrentRefused(f"{variable.name} does not depend on time.")
    if level_dim and level_dim not in kept:
        raise CurrentRefused(f"{variable.name} does not depend on depth.")
    if not level_dim:
        return values.reshape(1, -1)
    return values if kept[0] == level_dim else values.T
