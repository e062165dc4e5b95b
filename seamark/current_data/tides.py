"""Tidal constituents of a current, and the series that they predict.

The file is CSV with a row for each constituent: its name, the amplitude [m/s] and the Greenwich
phase [deg] along the major axis, the same along the minor axis (90 degrees clockwise), and the
direction of the major axis, clockwise from north; what NOAA publishes for its current stations:

    name,major_m_s,major_phase_deg,minor_m_s,minor_phase_deg,azimuth_deg
    M2,0.82,115.2,0.04,25.2,310

Z0 is the mean current, without phases. Astronomical arguments and nodal corrections are utide's
(the extra `tides`; Codiga 2011). The series has one level, since constituents are those of one.
"""

from __future__ import annotations

import csv
import math
from datetime import UTC, datetime
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.current_data.series import CurrentRefused, Series

Array = NDArray[np.float64]
CONSTITUENTS_MAX = 150
BYTES_MAX = 100_000
STEP_S = 300.0  # [s] E: far below a quarter of the fastest constituent's period
_COLUMNS = (
    *("name", "major_m_s", "major_phase_deg", "minor_m_s", "minor_phase_deg", "azimuth_deg"),
)
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


class Constituent(NamedTuple):
    """A row of the file."""

    name: str
    major: float
    major_phase: float
    minor: float
    minor_phase: float
    azimuth: float


def read_constituents(path: Path) -> list[Constituent]:
    """Return the constituents of a file; raises CurrentRefused."""
    try:
        with path.open("rb") as file:
            content = file.read(BYTES_MAX + 1)
    except OSError as error:
        raise CurrentRefused(f"The file cannot be read: {error.strerror}.") from None
    if len(content) > BYTES_MAX:
        raise CurrentRefused(f"A file of constituents has at most {BYTES_MAX} bytes.")
    text = content.decode("utf-8-sig", "replace").splitlines()
    rows = list(csv.reader(line for line in text if line.strip() and not line.startswith("#")))
    if not rows or tuple(one.strip().lower() for one in rows[0]) != _COLUMNS:
        raise CurrentRefused(f"The first line must be {','.join(_COLUMNS)}.")
    if not 1 <= len(rows) - 1 <= CONSTITUENTS_MAX:
        raise CurrentRefused(f"The file must have 1 to {CONSTITUENTS_MAX} constituents.")
    return [_constituent(row) for row in rows[1:]]


def _constituent(row: list[str]) -> Constituent:
    try:
        numbers = [float(text or 0.0) for text in row[1:]]
    except ValueError:
        numbers = []
    if len(numbers) != len(_COLUMNS) - 1 or not all(map(math.isfinite, numbers)):
        raise CurrentRefused(f"{row[0][:20]}: five numbers must follow the name.")
    return Constituent(row[0].strip().upper(), *numbers)


def predicted(
    constituents: list[Constituent],
    *,
    begin: datetime,
    hours: float,
    latitude_deg: float,
    height_m: float,
    step_s: float = STEP_S,
) -> Series:
    """Return the current that constituents predict from an instant on, at one height.

    Raises
    ------
    CurrentRefused
        utide is missing, or does not know a constituent.
    """
    times: Array = step_s * np.arange(int(hours * 3600.0 / step_s) + 1, dtype=np.float64)
    days: Array = (begin - _EPOCH).total_seconds() / 86400.0 + _EPOCH.toordinal() + times / 86400.0
    velocity = np.zeros((1, 3, times.size))
    factors, turns = _arguments([one.name for one in constituents], days, latitude_deg)
    for k, one in enumerate(constituents):
        parts = []
        for size, phase in ((one.major, one.major_phase), (one.minor, one.minor_phase)):
            angle = 2.0 * np.pi * turns[:, k] - np.deg2rad(phase)
            parts.append(factors[:, k] * size * np.cos(angle))
        north, east = np.cos(np.deg2rad(one.azimuth)), np.sin(np.deg2rad(one.azimuth))
        velocity[0, 0] += parts[0] * north - parts[1] * east
        velocity[0, 1] += parts[0] * east + parts[1] * north
    said = (
        f"{len(constituents)} constituents, with utide's nodal corrections for a latitude of "
        f"{latitude_deg:g} degrees.",
    )
    layout = "tidal constituents"
    begins = begin.isoformat(timespec="seconds")
    return Series(times, np.array([height_m]), velocity, False, layout, begins, said)


def _arguments(names: list[str], days: Array, latitude_deg: float) -> tuple[Array, Array]:
    """Return nodal factors and arguments [cycles] with nodal corrections, (n, k) each."""
    if find_spec("utide") is None:
        raise CurrentRefused('Constituents need the extra `tides`: pip install "seamark[tides]".')
    from utide._ut_constants import ut_constants
    from utide.harmonics import FUV

    known = {str(name).strip(): at for at, name in enumerate(ut_constants.const.name)}
    if unknown := [name for name in names if name not in known]:
        raise CurrentRefused(f"utide does not know the constituent {unknown[0][:20]}.")
    chosen = np.array([known[name] for name in names])
    factors, corrections, arguments = FUV(days, float(days.mean()), chosen, latitude_deg, [0] * 4)
    return np.asarray(factors), np.asarray(corrections + arguments)
