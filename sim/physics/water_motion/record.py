"""A record of currents: velocities over time at heights above the bottom, and its file.

The file is text: a first line that names the format, lines of `# name: value`, a line of column
names, and a row for each instant and height, ordered by both:

    # seamark-current 1
    # title: Synthetic ria
    time_s,height_m,north,east,down
    0,1.0,0.21,0.03,0.0

Every instant has the same heights and the same distance to the next; velocities are in m/s. There
are no gaps: `seamark current` fills or refuses them before it writes such a file.
"""

import math
import re
from dataclasses import dataclass

import numpy as np

from seamark.sim.files.library import FileInvalid
from seamark.sim.numerics.arrays import Array

BYTES_MAX = 2_000_000
FIRST_LINE = "# seamark-current 1"
COLUMNS = "time_s,height_m,north,east,down"
HEIGHTS_MAX, INSTANTS_MAX, INSTANTS_LEAST = 64, 20_000, 8
FASTEST_M_S = 10.0
STILL_M_S = 0.01  # [m/s] mean speed below which no stretch has a direction
_NOTE = re.compile(r"# ([a-z_]{1,20}): ([^\n]{0,300})")
_NOTES_MAX = 20
_NUMBERS = 5


class RecordInvalid(FileInvalid):
    """The file is not a record of currents. Its text is written for the user."""


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """Velocities at equally spaced instants."""

    step_s: float  # [s] between two instants
    heights: Array  # (h,) [m] above the bottom, increasing
    velocity: Array  # (h, 3, n) NED [m/s]
    notes: dict[str, str]

    @property
    def duration_s(self) -> float:
        """How long the record is."""
        return float(self.step_s * (self.velocity.shape[2] - 1))

    def strongest_mean(self, duration_s: float) -> float:
        """Return the largest mean horizontal speed [m/s] of a stretch so long, at any height."""
        fastest = 0.0
        for north, east, _down in self.velocity:
            x, y = means(np.array([north, east]), self.step_s, duration_s)
            fastest = max(fastest, float(np.sqrt(x * x + y * y).max()))
        return fastest

    @property
    def title(self) -> str:
        """What the record says it is."""
        return self.notes.get("title", "A record of currents")


def read_record(content: bytes) -> Record:
    """Return the record of a file.

    Raises
    ------
    RecordInvalid
        It is too large, or breaks a rule of the format.
    """
    if len(content) > BYTES_MAX:
        raise RecordInvalid(f"A record may have at most {BYTES_MAX} bytes.")
    try:
        lines = content.decode("utf-8").splitlines()
    except UnicodeDecodeError:
        raise RecordInvalid("A record must be text in UTF-8.") from None
    if not lines or lines[0].strip() != FIRST_LINE:
        raise RecordInvalid(
            f'A record begins with "{FIRST_LINE}": `seamark current FILE -o RECORD.csv` writes one.'
        )
    notes: dict[str, str] = {}
    at = 1
    while at < len(lines) and lines[at].startswith("#") and at <= _NOTES_MAX:
        if found := _NOTE.fullmatch(lines[at].strip()):
            notes[found[1]] = found[2]
        at += 1
    if at >= len(lines) or lines[at].replace(" ", "") != COLUMNS:
        raise RecordInvalid(f"After its notes a record has the line {COLUMNS}.")
    return _of_rows(_rows(lines[at + 1 :], at + 2), notes)


def write_record(record: Record) -> bytes:
    """Return the file of a record: heights with six digits, velocities with five."""
    lines = [FIRST_LINE, *(f"# {name}: {text}" for name, text in record.notes.items()), COLUMNS]
    heights = record.heights.tolist()
    for i in range(record.velocity.shape[2]):
        for h, height in enumerate(heights):
            north, east, down = record.velocity[h, :, i].tolist()
            lines.append(f"{i * record.step_s:.10g},{height:g},{north:.5g},{east:.5g},{down:.5g}")
    return ("\n".join(lines) + "\n").encode()


def means(velocity: Array, step_s: float, duration_s: float) -> Array:
    """Return the mean of (k, n) over a duration from each instant on that has one, (k, m)."""
    count = velocity.shape[1]
    window = min(max(math.ceil(duration_s / step_s), 1), count - 1)
    middles = 0.5 * (velocity[:, 1:] + velocity[:, :-1])
    sums = np.concatenate([np.zeros((len(velocity), 1)), np.cumsum(middles, axis=1)], axis=1)
    found: Array = (sums[:, window:] - sums[:, :-window]) / window
    return found


def _rows(lines: list[str], first: int) -> Array:
    """Return the numbers (rows, 5)."""
    if len(lines) > HEIGHTS_MAX * INSTANTS_MAX:
        raise RecordInvalid("The record has too many rows.")
    rows = []
    for number, line in enumerate(lines, first):
        if not line.strip():
            continue
        try:
            values = [float(part) for part in line.split(",")]
        except ValueError:
            values = []
        if len(values) != _NUMBERS or not all(map(math.isfinite, values)):
            raise RecordInvalid(f"Line {number} must have five numbers: {COLUMNS}.")
        rows.append(values)
    if not rows:
        raise RecordInvalid("The record has no rows.")
    return np.array(rows)


def _of_rows(rows: Array, notes: dict[str, str]) -> Record:
    starts = np.flatnonzero(np.diff(rows[:, 0], prepend=np.nan) != 0.0)
    count, heights = starts.size, rows.shape[0] // max(starts.size, 1)
    if count * heights != rows.shape[0] or not np.array_equal(starts, heights * np.arange(count)):
        raise RecordInvalid("Every instant of a record must have the same heights.")
    if not INSTANTS_LEAST <= count <= INSTANTS_MAX or heights > HEIGHTS_MAX:
        raise RecordInvalid(
            f"A record has {INSTANTS_LEAST} to {INSTANTS_MAX} instants and at most {HEIGHTS_MAX} "
            f"heights, not {count} and {heights}."
        )
    table = rows.reshape(count, heights, _NUMBERS)
    levels, times = table[0, :, 1], table[:, 0, 0]
    if not np.all(table[:, :, 1] == levels) or np.any(np.diff(levels) <= 0.0) or levels[0] < 0.0:
        raise RecordInvalid("The heights of a record must increase from row to row, from 0 up.")
    step_s = float(times[-1] - times[0]) / (count - 1)
    uneven = np.abs(np.diff(times) - step_s) > 1e-3 * step_s + 1e-6
    if not 0.0 < step_s < math.inf or np.any(uneven):
        raise RecordInvalid("The instants of a record must increase in equal steps.")
    velocity = np.ascontiguousarray(table[:, :, 2:].transpose(1, 2, 0))
    if np.any(np.abs(velocity) > FASTEST_M_S):
        raise RecordInvalid(f"A record must be in m/s; {FASTEST_M_S:g} m/s is the most.")
    if float(np.abs(velocity[:, :2]).max()) < STILL_M_S:
        raise RecordInvalid("The water of the record is still.")
    return Record(step_s, levels.copy(), velocity, notes)
