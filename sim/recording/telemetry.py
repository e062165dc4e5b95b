"""The telemetry: one row of float64 per control tick, the same columns everywhere.

A row holds the state at the tick, the picture of that state, what the tracker and the program made
of it, and the thrust that acted. Positions are in the world frame (NED), velocities in the
body frame.
"""

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seamark.sim.control.observation import THRUSTERS

Rows = NDArray[np.float64]  # (k, len(COLUMNS))


@dataclass(frozen=True, slots=True)
class Column:
    """One column. `shape` is () because vectors are written as one column per number."""

    name: str
    unit: str
    meaning: str
    shape: tuple[int, ...] = ()


def _vector(names: str, unit: str, meaning: str) -> tuple[Column, ...]:
    return tuple(Column(name, unit, meaning) for name in names.split())


COLUMNS: tuple[Column, ...] = (
    Column("trial", "", "index of the trial, from 0"),
    Column("level", "", "index of the level, from 0"),
    Column("t", "s", "simulated time since the trial began"),
    *_vector("x y z", "m", "position of the vehicle's origin, world frame: north, east, down"),
    *_vector("roll pitch yaw", "rad", "attitude of the vehicle"),
    *_vector("u v w", "m/s", "velocity over ground, body frame: surge, sway, heave"),
    *_vector("p q r", "rad/s", "angular velocity, body frame"),
    *_vector("current_x current_y current_z", "m/s", "velocity of the water, world frame"),
    *_vector("target_x target_y", "px", "true place of the target; nan while it has no image"),
    *_vector("tracked_x tracked_y", "px", "place of the target by the tracker"),
    *(
        Column(f"corner_{i}", "px", "corner of the target by the tracker, x0 y0 to x3 y3")
        for i in range(8)
    ),
    Column("tracker_ok", "", "1 while the tracker says that it has the target"),
    Column("tracker_error", "px", "root mean square distance of the tracked from the true corners"),
    *_vector("error_x error_y error_z", "m", "how far to move, body frame, as the program saw it"),
    Column("error_x_px", "px", "true target minus image centre along image X (starboard)"),
    Column("error_y_px", "px", "true target minus image centre along image Y (aft)"),
    Column("distance_px", "px", "true distance of the target from the image centre"),
    Column("distance", "m", "true distance of the camera from its station above the target"),
    *_vector("ref_u ref_v ref_w", "m/s", "velocity reference of the program: surge, sway, heave"),
    Column("ref_r", "rad/s", "yaw rate reference of the program"),
    *_vector("dvl_u dvl_v dvl_w", "m/s", "last velocity measured by the DVL, body frame"),
    *(
        Column(f"thrust_{i}", "N", "thrust of one thruster; 0 beyond the vehicle's own number")
        for i in range(THRUSTERS)
    ),
    Column(
        "contact_n",
        "N",
        "force of bottom and target on the hull, mean of its size since the row before",
    ),
    Column("step_us", "us", "wall time that the program took; not part of the digest"),
)
NAMES: tuple[str, ...] = tuple(column.name for column in COLUMNS)
INDEX: dict[str, int] = {name: at for at, name in enumerate(NAMES)}
WIDTH = len(COLUMNS)
STEP_US = INDEX["step_us"]
DIGESTED = tuple(at for at in range(WIDTH) if at != STEP_US)


class Recorder:
    """A buffer of rows for one stretch of time, filled in place and handed out as copies."""

    def __init__(self, rows: int) -> None:
        self._buffer = np.zeros((rows, WIDTH))
        self._filled = 0

    def next_row(self) -> NDArray[np.float64]:
        """Return the row to be written, (WIDTH,); it counts only after `keep`."""
        row: NDArray[np.float64] = self._buffer[self._filled]
        return row

    def keep(self) -> bool:
        """Count the row; True when the buffer is full."""
        self._filled += 1
        return self._filled == len(self._buffer)

    def take(self) -> Rows:
        """Return a copy of the rows since the last call, and start again."""
        rows = self._buffer[: self._filled].copy()
        self._filled = 0
        return rows


class Digest:
    """SHA-256 over rows as they come, without the columns of wall time."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()

    def add(self, rows: Rows) -> None:
        """Add rows, (k, WIDTH); how they are cut into calls makes no difference."""
        self._hash.update(np.ascontiguousarray(rows[:, DIGESTED], dtype="<f8").tobytes())

    def hexdigest(self) -> str:
        """Return 64 hexadecimal digits."""
        return self._hash.hexdigest()

    def copy(self) -> "Digest":
        """Return a digest of the same rows that goes on by itself."""
        other = Digest()
        other._hash = self._hash.copy()
        return other


def digest(rows: Rows) -> str:
    """Return the SHA-256 of rows, without the columns of wall time."""
    whole = Digest()
    whole.add(rows)
    return whole.hexdigest()


def units() -> str:
    """Return the line for a table's head that says what the columns are in."""
    told = (f"{one.name} [{one.unit}]" if one.unit else one.name for one in COLUMNS)
    return "columns: " + ", ".join(told)


def header(comments: Iterable[str] = ()) -> str:
    """Return the lines before the data: comments, then the names of the columns."""
    lines = [f"# {line}" for comment in comments for line in comment.splitlines() or [""]]
    return "\n".join([*lines, ",".join(NAMES)]) + "\n"


def csv_lines(rows: Rows) -> str:
    """Return rows as text; every float is the shortest that reads back as the same number."""
    return "".join(",".join(map(_shortest, row)) + "\n" for row in rows.tolist())


def _shortest(value: float) -> str:
    text = repr(value)
    return text[:-2] if text.endswith(".0") else text


def to_csv(rows: Rows, comments: Iterable[str] = ()) -> str:
    """Return a whole CSV document; works on any number of rows, also none."""
    return header(comments) + csv_lines(rows)


def csv_chunks(rows: Rows, comments: Iterable[str] = (), *, size: int = 1200) -> Iterator[str]:
    """Yield a CSV document in pieces of `size` rows, for a download that starts at once."""
    yield header(comments)
    for start in range(0, len(rows), size):
        yield csv_lines(rows[start : start + size])


def from_csv(text: str) -> Rows:
    """Return the rows of a CSV document made by `to_csv`, (k, WIDTH).

    Raises
    ------
    ValueError
        If the names of the columns are not this version's.
    """
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    if not lines or tuple(lines[0].split(",")) != NAMES:
        raise ValueError("the header row does not name the columns of this version")
    values = [list(map(float, line.split(","))) for line in lines[1:]]
    return np.array(values).reshape(len(values), WIDTH)


def from_bytes(data: bytes) -> Rows:
    """Return the whole rows in little-endian float64 bytes; a row cut off is left out."""
    whole = len(data) // (8 * WIDTH) * (8 * WIDTH)
    return np.frombuffer(data[:whole], dtype="<f8").reshape(-1, WIDTH).astype(np.float64)
