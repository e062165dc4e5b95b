"""Telemetry: one row of float64 per control step.

A row holds the state at the start of the step, the tracker's estimate from the image of that state,
the program's velocity reference and the thrust acting at that moment. Positions are in the world
frame (NED), velocities in the body frame.

Every row begins with the same `WIDTH` columns, which include eight thrusters. A vehicle with an arm
has `ARM_WIDTH` further columns, one that works on something `WORK_WIDTH` more, one that first has
to find it `SEARCH_WIDTH` more, one without an arm that follows a route `ROUTE_WIDTH` more, one that
enters a dock `DOCK_WIDTH` more, a row of a detector `DETECTION_WIDTH` more, and a vehicle with more
thrusters has theirs at the end. These are fewer than the columns of any group, those of a route
with them fewer than those of a dock, these fewer than those of an arm, and those of a detector more
than all others together, so the width of a row says which columns it has, and rows of all versions
and vehicles can be read alike. Rows with a dock have a column for every thruster that a vehicle may
have: with only those there are, some would be as wide as rows of a route.
"""

import hashlib
from collections import Counter
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass

import numpy as np
import orjson
from numpy.typing import NDArray

from seamark.sim.vehicles.patterns import CLASSES

Rows = NDArray[np.float64]  # (k, WIDTH or more)
OnRows = Callable[[Rows], None]

COMMON_THRUSTERS = 8  # thrust columns in every row, whatever the vehicle; part of the file format
ARM_JOINTS, ARM_FEELERS = 8, 4  # in every row with an arm, whatever the arm
ANSWERS = 16  # of a detector to one image that are kept
_WIDTH_BYTES = 4
_POINT_MIN, _POINT_END = 1e-4, 1e16  # between them Python writes a float without an exponent
DELIVERED_ROWS = 20  # at once: 1 s of simulated time at 20 Hz


@dataclass(frozen=True, slots=True)
class Column:
    """One column: a single number, so a vector takes several."""

    name: str
    unit: str
    meaning: str


def _thrust(index: int) -> Column:
    return Column(f"thrust_{index}", "N", "thrust of one thruster; 0 if the vehicle has fewer")


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
    *_vector("target_x target_y", "px", "true image position of the target, also beyond the edges"),
    *_vector("tracked_x tracked_y", "px", "image position of the target according to the tracker"),
    *(
        Column(f"corner_{i}", "px", "corner of the target according to the tracker, x0 y0 to x3 y3")
        for i in range(8)
    ),
    Column("tracker_ok", "", "1 while the tracker reports that it has the target"),
    Column("tracker_error", "px", "root mean square distance between tracked and true corners"),
    *_vector("error_x error_y error_z", "m", "position error as the program sees it, body frame"),
    Column("error_x_px", "px", "true target minus image centre along image X (starboard)"),
    Column("error_y_px", "px", "true target minus image centre along image Y (aft)"),
    Column("distance_px", "px", "true distance of the target from the image centre"),
    Column("distance", "m", "true distance of the camera from its station above the target"),
    *_vector("ref_u ref_v ref_w", "m/s", "velocity reference of the program: surge, sway, heave"),
    Column("ref_r", "rad/s", "yaw rate reference of the program"),
    *_vector("dvl_u dvl_v dvl_w", "m/s", "last velocity measured by the DVL, body frame"),
    *map(_thrust, range(COMMON_THRUSTERS)),
    Column(
        "contact_n",
        "N",
        "magnitude of the contact force on the hull, mean since the previous row",
    ),
    Column("step_us", "us", "wall time of the program's step; not part of the digest"),
)


def _joints(name: str, unit: str, meaning: str) -> tuple[Column, ...]:
    return tuple(
        Column(f"{name}_{i}", unit, f"{meaning}; 0 if there is none") for i in range(ARM_JOINTS)
    )


ARM_COLUMNS: tuple[Column, ...] = (
    *_joints("joint", "rad", "coordinate of one joint of the arm, m if it slides"),
    *_joints("joint_speed", "rad/s", "speed of one joint"),
    *_joints("joint_ref", "rad/s", "speed of one joint that the program commands"),
    *_joints("joint_effort", "N m", "torque of one joint's motor, mean since the previous row"),
    *_vector(
        "wrist_fx wrist_fy wrist_fz",
        "N",
        "force of the arm on what its force sensor carries, sensor's axes, mean since the last row",
    ),
    *_vector("wrist_mx wrist_my wrist_mz", "N m", "moment of the same"),
    *(
        Column(f"touch_{i}", "N", "contact force on one part of the hand, mean since the last row")
        for i in range(ARM_FEELERS)
    ),
    Column("arm_peak_n", "N", "contact force on the arm from outside it, most since the last row"),
)
WORK_COLUMNS: tuple[Column, ...] = (
    *_vector(
        "workpiece_x workpiece_y workpiece_z",
        "m",
        "position of the origin of what is worked on, world frame",
    ),
    *_vector("workpiece_roll workpiece_pitch workpiece_yaw", "rad", "its attitude"),
    *_vector(
        "workpiece_u workpiece_v workpiece_w",
        "m/s",
        "its velocity over ground in its axes, if it moves freely, else 0",
    ),
    *_vector("workpiece_p workpiece_q workpiece_r", "rad/s", "its angular velocity likewise"),
    Column("workpiece_joint", "rad", "coordinate of its joint, if it is on one, else 0"),
    Column("workpiece_joint_speed", "rad/s", "speed of this joint"),
    Column("reach", "m", "distance of the tool centre point from where it should grip"),
    *_vector("tool_x tool_y tool_z", "m", "tool centre point of the arm, world frame"),
    *_vector("tool_roll tool_pitch tool_yaw", "rad", "attitude of the tool, which points along x"),
    Column("work_arm_n", "N", "contact force of the arm on the workpiece, mean since the last row"),
    Column("work_hull_n", "N", "the same of the vehicle's hull"),
    Column("work_rest_n", "N", "the same of the seabed and of all other things"),
    Column("work_push_n", "N", "magnitude of the net contact force of the arm on it, mean as well"),
    *_vector("work_fx work_fy work_fz", "N", "this net force, world frame"),
)
# Of a detector that looks for the target of a tracker.
_LOOKING = (
    Column("searching", "", "1 while no target is being tracked, so that a detector looks for one"),
    Column("looked", "", "1 if a detector was given the image of this row"),
)
_FOUND = (
    *_vector(
        "found_x0 found_y0 found_x1 found_y1 found_x2 found_y2 found_x3 found_y3",
        "px",
        "corners of the most confident answer to this image; nan if there is none",
    ),
    Column("found_confidence", "", "its confidence, 0 to 1; nan if there is none"),
)
SEARCH_COLUMNS: tuple[Column, ...] = (
    *_LOOKING,
    Column("confidence", "", "of the last answer on the target that is tracked, or 0; 0 to 1"),
    *_FOUND,
    *_vector("decoy_x decoy_y decoy_z", "m", "position of the wrong thing's origin, world frame"),
    *_vector("decoy_roll decoy_pitch decoy_yaw", "rad", "its attitude"),
    *_vector("decoy_u decoy_v decoy_w", "m/s", "its velocity over ground in its axes"),
    *_vector("decoy_p decoy_q decoy_r", "rad/s", "its angular velocity likewise"),
    Column("decoy_arm_n", "N", "contact force of the arm on the wrong thing, mean since last row"),
    Column("decoy_hull_n", "N", "the same of the vehicle's hull"),
    Column("decoy_rest_n", "N", "the same of the seabed and of all other things"),
)
ROUTE_COLUMNS: tuple[Column, ...] = (
    *_vector(
        "route_x route_y route_z",
        "m",
        "point of the route that is nearest to the vehicle on the piece that is due, world frame",
    ),
    *_vector("route_dx route_dy route_dz", "", "direction of the route there, a unit vector"),
    Column("route_along", "m", "how far along the route the vehicle has followed it"),
    Column("route_length", "m", "length of the whole route"),
    Column("cross_track", "m", "distance of the vehicle's origin from that point"),
    Column("cross_track_y", "m", "its part that is level and to starboard of the route"),
    Column("cross_track_z", "m", "its part down"),
    *_vector("fix_x fix_y fix_z", "m", "position by the last acoustic fix, world frame"),
    Column("fix_age", "s", "time since this position was measured; nan before the first fix"),
    Column("fix_sigma", "m", "standard deviation of each of its axes that the system states"),
    Column("fix_range", "m", "measured distance from the transceiver"),
    *_vector("fix_bearing fix_elevation", "rad", "measured direction, from north and downwards"),
    *_vector("boat_x boat_y boat_z", "m", "position of the acoustic transceiver, world frame"),
)
DOCK_COLUMNS: tuple[Column, ...] = (
    *_vector(
        "dock_x dock_y dock_z",
        "m",
        "where the vehicle's origin is when it is docked, world frame",
    ),
    Column("dock_heading", "rad", "its heading when it is docked"),
    *_vector(
        "dock_ahead dock_side dock_below",
        "m",
        "vehicle's origin from there: forward, to starboard and down in the dock's axes",
    ),
    Column("dock_turn", "rad", "vehicle's heading less that of the dock, -pi to pi"),
    Column("dock_depth", "m", "how far the keel is below the mouth of the dock; negative above"),
    *_vector("dock_fix_x dock_fix_y dock_fix_z", "m", "the dock by its last acoustic answer"),
    Column("dock_fix_age", "s", "time since it was asked; nan before the first answer"),
    Column("dock_fix_sigma", "m", "standard deviation of each level axis of it"),
    Column("dock_range", "m", "measured distance of the dock from the vehicle"),
    *_vector("dock_bearing dock_elevation", "rad", "measured direction, from north and downwards"),
    *_vector("light_x light_y", "px", "the dock's lamps in the image; nan where they are not seen"),
    *_LOOKING,
    *_FOUND,
)
_CORNERS = "x0 y0 x1 y1 x2 y2 x3 y3"
OBJECT_COLUMNS: tuple[Column, ...] = (
    Column("state", "", "object of one class: 0 not in the image, 1 counts, 2 is ignored"),
    *_vector(_CORNERS, "px", "true corners of its plan rectangle; nan while it is not in view"),
    Column("visible", "", "share of it that is in the image and not covered, 0 to 1"),
    Column("distance", "m", "distance of the camera from its centre"),
    Column("angle", "rad", "angle between the line of sight to its centre and its normal"),
)
ANSWER_COLUMNS: tuple[Column, ...] = (
    Column("label", "", "answer, most confident first: index of the class; -1 if there is none"),
    Column("confidence", "", "its confidence, 0 to 1"),
    *_vector(_CORNERS, "px", "its corners"),
    Column("outcome", "", "0 no answer, 1 hit, 2 false alarm, 3 ignored"),
    Column("iou", "", "its intersection over union with the object of its class, by bounding box"),
    Column("error", "px", "root mean square error of the corners of a hit, else nan"),
    Column("on", "", "what it lies on: index of the class, 100 + index of the decoy, -1 nothing"),
)


def _each(name: str, count: int, group: tuple[Column, ...]) -> tuple[Column, ...]:
    return tuple(
        Column(f"{name}_{index}_{one.name}", one.unit, one.meaning)
        for index in range(count)
        for one in group
    )


DETECTION_COLUMNS: tuple[Column, ...] = (
    *_each("object", len(CLASSES), OBJECT_COLUMNS),
    *_each("answer", ANSWERS, ANSWER_COLUMNS),
)
OBJECT: dict[str, int] = {column.name: at for at, column in enumerate(OBJECT_COLUMNS)}
ANSWER: dict[str, int] = {column.name: at for at, column in enumerate(ANSWER_COLUMNS)}
NAMES: tuple[str, ...] = tuple(column.name for column in COLUMNS)
INDEX: dict[str, int] = {name: at for at, name in enumerate(NAMES)}
WIDTH, ARM_WIDTH, WORK_WIDTH = len(COLUMNS), len(ARM_COLUMNS), len(WORK_COLUMNS)
ARM_INDEX: dict[str, int] = {column.name: WIDTH + at for at, column in enumerate(ARM_COLUMNS)}
DETECTION_WIDTH = len(DETECTION_COLUMNS)
SEARCH_WIDTH, ROUTE_WIDTH = len(SEARCH_COLUMNS), len(ROUTE_COLUMNS)
DOCK_WIDTH, DOCK_THRUSTERS = len(DOCK_COLUMNS), 20
_DOCK_WHOLE = WIDTH + DOCK_WIDTH + DOCK_THRUSTERS - COMMON_THRUSTERS
_WORK_START = WIDTH + ARM_WIDTH
_SEARCH_START = _WORK_START + WORK_WIDTH
WORK_INDEX: dict[str, int] = {
    column.name: _WORK_START + at for at, column in enumerate(WORK_COLUMNS)
}
SEARCH_INDEX: dict[str, int] = {
    column.name: _SEARCH_START + at for at, column in enumerate(SEARCH_COLUMNS)
}
ROUTE_INDEX: dict[str, int] = {column.name: WIDTH + at for at, column in enumerate(ROUTE_COLUMNS)}
DOCK_INDEX: dict[str, int] = {column.name: WIDTH + at for at, column in enumerate(DOCK_COLUMNS)}
STEP_US = INDEX["step_us"]
POSE_COLUMNS: tuple[str, ...] = ("x", "y", "z", "roll", "pitch", "yaw")


def has_detections(width: int) -> bool:
    """Return whether rows of this width are those of a detector."""
    return width >= WIDTH + DETECTION_WIDTH


def _without_detections(width: int) -> int:
    return width - has_detections(width) * DETECTION_WIDTH


def has_arm(width: int) -> bool:
    """Return whether rows of this width are those of a vehicle with an arm."""
    return _without_detections(width) >= WIDTH + ARM_WIDTH


def has_work(width: int) -> bool:
    """Return whether rows of this width are those of an arm that works on something."""
    return _without_detections(width) >= WIDTH + ARM_WIDTH + WORK_WIDTH


def has_search(width: int) -> bool:
    """Return whether rows of this width are those of a vehicle that first looks for its work."""
    return _without_detections(width) >= WIDTH + ARM_WIDTH + WORK_WIDTH + SEARCH_WIDTH


def has_route(width: int) -> bool:
    """Return whether rows of this width are those of a vehicle that follows a route."""
    return WIDTH + ROUTE_WIDTH <= _without_detections(width) < _DOCK_WHOLE


def has_dock(width: int) -> bool:
    """Return whether rows of this width are those of a vehicle that enters a dock."""
    return _DOCK_WHOLE <= _without_detections(width) < WIDTH + ARM_WIDTH


def _before_detections(width: int) -> int:
    work = WIDTH + has_arm(width) * ARM_WIDTH + has_work(width) * WORK_WIDTH
    alone = has_route(width) * ROUTE_WIDTH + has_dock(width) * DOCK_WIDTH
    return work + has_search(width) * SEARCH_WIDTH + alone


def _before_thrusts(width: int) -> int:
    """Return how many columns come before those of further thrusters."""
    return _before_detections(width) + has_detections(width) * DETECTION_WIDTH


def columns(width: int) -> tuple[Column, ...]:
    """Return the columns of rows of this width."""
    arm = ARM_COLUMNS if has_arm(width) else ()
    work = WORK_COLUMNS if has_work(width) else ()
    search = SEARCH_COLUMNS if has_search(width) else ()
    route = ROUTE_COLUMNS if has_route(width) else ()
    dock = DOCK_COLUMNS if has_dock(width) else ()
    detections = DETECTION_COLUMNS if has_detections(width) else ()
    thrusters = COMMON_THRUSTERS + width - _before_thrusts(width)
    further = map(_thrust, range(COMMON_THRUSTERS, thrusters))
    return (*COLUMNS, *arm, *work, *search, *route, *dock, *detections, *further)


def names(width: int) -> tuple[str, ...]:
    """Return the names of the columns of rows of this width."""
    return tuple(column.name for column in columns(width))


def width_for(
    thrusters: int,
    *,
    arm: bool = False,
    work: bool = False,
    search: bool = False,
    route: bool = False,
    dock: bool = False,
    detections: bool = False,
) -> int:
    """Return the width of a row for a vehicle with this number of thrusters.

    `arm` is whether it has an arm, `work` whether that works on something, `search` whether it
    first looks for it, `route` whether it follows one, `dock` whether it enters one, `detections`
    whether a detector answers its images.
    """
    own = WIDTH + arm * ARM_WIDTH + work * WORK_WIDTH + search * SEARCH_WIDTH
    own += route * ROUTE_WIDTH + dock * DOCK_WIDTH + detections * DETECTION_WIDTH
    thrusters = DOCK_THRUSTERS if dock else thrusters
    return own + max(thrusters - COMMON_THRUSTERS, 0)


def _known_by() -> dict[str, str]:
    """Return kind of columns -> the first of them that no other kind has."""
    kinds = {
        "arm": ARM_COLUMNS,
        "work": WORK_COLUMNS,
        "search": SEARCH_COLUMNS,
        "route": ROUTE_COLUMNS,
        "dock": DOCK_COLUMNS,
        "detections": DETECTION_COLUMNS,
    }
    every = Counter(column.name for kind in kinds.values() for column in kind)
    return {
        name: next(column.name for column in kind if every[column.name] == 1)
        for name, kind in kinds.items()
    }


_KNOWN_BY = _known_by()


def width_of(written: Collection[str]) -> int:
    """Return the width of this version's rows for a run whose rows were written with these names.

    Another version may have written them: kinds are told by one name each, so that columns can
    have come or gone since.
    """
    thrusters = sum(name.startswith("thrust_") for name in written)
    return width_for(thrusters, **{kind: name in written for kind, name in _KNOWN_BY.items()})


def detections(rows: Rows) -> Rows:
    """Return the columns of a detector in a row or rows that have them, (..., DETECTION_WIDTH).

    It is a view: what is written to it is written to the rows.
    """
    return rows[..., detections_slice(rows.shape[-1])]


def objects_of(columns: Rows) -> Rows:
    """Return the true objects in the columns of a detector, (..., classes, OBJECT_COLUMNS).

    As `detections`, it is a view.
    """
    own = columns[..., : len(CLASSES) * len(OBJECT_COLUMNS)]
    return own.reshape(*columns.shape[:-1], len(CLASSES), len(OBJECT_COLUMNS))


def answers_of(columns: Rows) -> Rows:
    """Return the answers in them likewise, (..., ANSWERS, ANSWER_COLUMNS)."""
    own = columns[..., len(CLASSES) * len(OBJECT_COLUMNS) :]
    return own.reshape(*columns.shape[:-1], ANSWERS, len(ANSWER_COLUMNS))


def detections_slice(width: int) -> slice:
    """Return where rows of this width have the columns of a detector; empty if they have none."""
    first = _before_detections(width)
    return slice(first, first + has_detections(width) * DETECTION_WIDTH)


def numbered(name: str, count: int) -> tuple[str, ...]:
    """Return the names of columns that differ by a number, such as joint_0 and joint_1."""
    return tuple(f"{name}_{index}" for index in range(count))


def thrust_names(thrusters: int) -> tuple[str, ...]:
    """Return the names of the columns with the thrust of a vehicle's thrusters."""
    return numbered("thrust", thrusters)


def thrusts(rows: Rows) -> Rows:
    """Return the thrust columns of rows, (k, 8 or more) [N]."""
    first = INDEX["thrust_0"]
    common = rows[:, first : first + COMMON_THRUSTERS]
    further = rows[:, _before_thrusts(rows.shape[1]) :]
    return np.hstack([common, further]) if further.shape[1] else common


class Recorder:
    """Collects the rows of one level and passes copies on, so many at a time."""

    def __init__(self, on_rows: OnRows, *, width: int, together: int = DELIVERED_ROWS) -> None:
        self._buffer = np.zeros((together, width))
        self._filled = 0
        self._on_rows = on_rows

    def next_row(self) -> NDArray[np.float64]:
        """Return the row to write to; it counts once `commit` is called."""
        row: NDArray[np.float64] = self._buffer[self._filled]
        return row

    def commit(self) -> None:
        """Count the row that was written; pass the rows on if the buffer is full."""
        self._filled += 1
        if self._filled == len(self._buffer):
            self.flush()

    def flush(self) -> None:
        """Pass on the rows collected since the last time, if any."""
        rows = self._buffer[: self._filled].copy()
        self._filled = 0
        if len(rows):
            self._on_rows(rows)


class Digest:
    """SHA-256 of rows as they arrive, without the column of wall times."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()

    def add(self, rows: Rows) -> None:
        """Add rows; how they are split over calls makes no difference."""
        # Slices take half the time of np.delete; most rows have nothing after the wall time.
        kept = np.hstack([rows[:, :STEP_US], rows[:, STEP_US + 1 :]])
        self._hash.update(np.ascontiguousarray(kept, dtype="<f8").tobytes())

    def hexdigest(self) -> str:
        """Return 64 hexadecimal digits."""
        return self._hash.hexdigest()

    def copy(self) -> "Digest":
        """Return an independent digest of the rows so far."""
        other = Digest()
        other._hash = self._hash.copy()
        return other


def digest(rows: Rows) -> str:
    """Return the SHA-256 of rows, without the column of wall times."""
    whole = Digest()
    whole.add(rows)
    return whole.hexdigest()


def units(width: int = WIDTH) -> str:
    """Return a comment line with the unit of each column."""
    described = (f"{one.name} [{one.unit}]" if one.unit else one.name for one in columns(width))
    return "columns: " + ", ".join(described)


def header(comments: Iterable[str] = (), *, width: int = WIDTH) -> str:
    """Return the lines above the data of a CSV document: comments, then the column names."""
    lines = [f"# {line}" for comment in comments for line in comment.splitlines() or [""]]
    return "\n".join([*lines, ",".join(names(width))]) + "\n"


def csv_lines(rows: Rows) -> str:
    """Return rows as CSV; every float is the shortest text that reads back as the same number.

    It is Python's text of a float, without the ".0" of whole numbers, whose digits orjson writes
    ten times faster. Numbers that Python writes with an exponent, infinities and nan are few:
    orjson writes "null" for them, and they are put in one by one.
    """
    if not len(rows):
        return ""
    magnitude = np.abs(rows)
    with_point = (magnitude >= _POINT_MIN) & (magnitude < _POINT_END) | (rows == 0.0)
    digits = orjson.dumps(np.where(with_point, rows, np.nan), option=orjson.OPT_SERIALIZE_NUMPY)
    lines = digits[2:-2].decode().replace("],[", "\n") + "\n"
    first, *following = lines.replace(".0,", ",").replace(".0\n", "\n").split("null")
    others = rows[~with_point].tolist()
    return first + "".join(f"{one!r}{text}" for one, text in zip(others, following, strict=True))


def to_bytes(rows: Rows) -> bytes:
    """Return rows as a message for `from_bytes`: the width, then little-endian float64."""
    width: int = rows.shape[1]
    return (
        width.to_bytes(_WIDTH_BYTES, "little") + np.ascontiguousarray(rows, dtype="<f8").tobytes()
    )


def from_bytes(message: bytes) -> Rows:
    """Return the rows that `to_bytes` packed."""
    width = int.from_bytes(message[:_WIDTH_BYTES], "little")
    return np.frombuffer(message, "<f8", offset=_WIDTH_BYTES).reshape(-1, width)
