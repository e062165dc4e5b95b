"""The metrics of the original benchmark module (uwsimbenchmarks), from telemetry rows.

The definitions are the original's; where it is wrong, they are corrected. `docs/measures.md` has
all formulas and names each error.
"""

import math
from collections.abc import Mapping, Sequence
from functools import cached_property, partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from seamark.sim.metrics.metric import (
    MAX,
    SUM,
    Absent,
    Aggregation,
    LevelMetric,
    Levels,
    MetricGroup,
    compute_all,
    over_run,
    weighted_by,
)
from seamark.sim.metrics.windows import LOST_COLUMNS
from seamark.sim.numerics.exact_sums import exact_mean
from seamark.sim.numerics.statistics import mean
from seamark.sim.recording.telemetry import INDEX, ROUTE_INDEX, Rows, has_route

COLLISION_SPEED_M_S = 0.5  # S: uwsimbenchmarks, the speed at which a collision scores 0
Point = tuple[float, float, float]  # [m] NED
Column = NDArray[np.float64]  # (k,)
Turn = tuple[Column, Column]  # sine and cosine
ANGLES = ("roll", "pitch", "yaw")
_POSITION = ("x", "y", "z")
_CONTACT_COLUMNS = ("contact_n", "u", "v", "w")
_CENTRED = ("distance_px", "error_x_px", "error_y_px")


def time(rows: Rows) -> float:
    """Return the simulated time from the first row to the last [s]."""
    t = _column(rows, "t")
    return t[-1] - t[0] if t else math.nan


def contacts(rows: Rows) -> dict[str, float]:
    """Return the number of control steps in contact, and mean and maximum speed [m/s] in them."""
    touching = rows[rows[:, INDEX["contact_n"]] > 0.0]
    speeds = _lengths(touching[:, INDEX["u"] : INDEX["w"] + 1])
    return {
        "steps": float(len(speeds)),
        "mean_speed": mean(speeds) if speeds else 0.0,
        "max_speed": max(speeds, default=0.0),
    }


def collision(*, steps: float, mean_speed: float, max_speed: float) -> float:
    """Return the collision score, 1 (none) to 0, from what `contacts` returns."""
    if not steps:
        return 1.0
    return max(0.0, 1.0 - (mean_speed + max_speed) / COLLISION_SPEED_M_S)


def position_error(rows: Rows, target: Point) -> dict[str, float]:
    """Return the mean distance from a position, NED, and the mean absolute error per axis [m]."""
    off = rows[:, INDEX["x"] : INDEX["z"] + 1] - np.array(target)
    axes = {axis: exact_mean(np.abs(off[:, i])) for i, axis in enumerate("xyz")}
    return {"total": mean(_lengths(off))} | axes


def attitude_error(rows: Rows) -> float:
    """Return the mean angle [rad] of the rotation from the attitude at the start of the level."""
    rotation = _rotation(*(_sine_and_cosine(_column(rows, name)) for name in ANGLES))
    # The trace of the rotation between two attitudes is 1 + 2 cos(angle).
    trace = sum(entry * entry[0] for entry in rotation)
    cosines = np.clip(0.5 * (trace - 1.0), -1.0, 1.0)
    return mean([*map(math.acos, cosines.tolist())])


def distance(rows: Rows) -> float:
    """Return the travelled distance [m], without the resets between levels."""
    steps = np.diff(rows[:, INDEX["x"] : INDEX["z"] + 1], axis=0)
    same = np.diff(rows[:, INDEX["level"]]) == 0.0
    return math.fsum(_lengths(steps[same]))


def euclidean_norm(rows: Rows) -> dict[str, float]:
    """Return the mean norms of the error of corners and centroid [px]; nan without a target.

    Telemetry keeps the root mean square over four corners; the norm of all eight is twice that.
    """
    seen = rows[rows[:, INDEX["tracker_ok"]] == 1.0]
    off = seen[:, _columns("tracked_x", "tracked_y")] - seen[:, _columns("target_x", "target_y")]
    return {
        "corners": 2.0 * exact_mean(seen[:, INDEX["tracker_error"]]),
        "centroid": mean(_lengths(off)),
    }


def object_centered_on_cam(rows: Rows) -> dict[str, float]:
    """Return the mean distance of the true target from the image centre, and by axis [px]."""
    return {
        "total": exact_mean(rows[:, INDEX["distance_px"]]),
        "x": exact_mean(np.abs(rows[:, INDEX["error_x_px"]])),
        "y": exact_mean(np.abs(rows[:, INDEX["error_y_px"]])),
    }


def path_following(rows: Rows, path: Sequence[Point], dt: float) -> dict[str, float]:
    """Return IAE [m s], ISE [m² s] and mean distance [m] to a path of one or more points, NED."""
    positions = rows[:, INDEX["x"] : INDEX["z"] + 1]
    if len(path) == 1:
        off = _lengths(positions - np.array(path[0]))
    else:
        segments = list(pairwise(path))
        off = [
            min(_to_segment(position, *segment) for segment in segments)
            for position in positions.tolist()
        ]
    return path_errors(off, dt)


def path_errors(off: Sequence[float], dt: float) -> dict[str, float]:
    """Return IAE [m s], ISE [m² s] and mean [m] of distances to a path [m], one each `dt` [s]."""
    return {
        "iae": math.fsum(off) * dt,
        "ise": math.fsum(value * value for value in off) * dt,
        "distanceToPath": mean(off),
    }


def _to_segment(position: Sequence[float], start: Sequence[float], end: Sequence[float]) -> float:
    along = [b - a for a, b in zip(start, end, strict=True)]
    off = [p - a for a, p in zip(start, position, strict=True)]
    square = math.fsum(value * value for value in along)
    share = math.fsum(a * b for a, b in zip(along, off, strict=True)) / square if square else 0.0
    share = min(max(share, 0.0), 1.0)
    return math.dist(off, [share * value for value in along])


def _sine_and_cosine(angles: Sequence[float]) -> tuple[Column, Column]:
    count = len(angles)  # not NumPy's, whose last bits depend on the processor
    sines = np.fromiter(map(math.sin, angles), np.float64, count)
    return sines, np.fromiter(map(math.cos, angles), np.float64, count)


def _rotation(roll: Turn, pitch: Turn, yaw: Turn) -> tuple[Column, ...]:
    """Return the nine entries of the rotation from body to world, row by row (Fossen 2021)."""
    (sr, cr), (sp, cp), (sy, cy) = roll, pitch, yaw
    return (
        *(cy * cp, cy * sp * sr - sy * cr, sy * sr + cy * cr * sp),
        *(sy * cp, cy * cr + sr * sp * sy, sp * sy * cr - cy * sr),
        *(-sp, cp * sr, cp * cr),
    )


def _columns(*names: str) -> list[int]:
    return [INDEX[name] for name in names]


def _column(rows: Rows, name: str) -> list[float]:
    values: list[float] = rows[:, INDEX[name]].tolist()
    return values


def _lengths(vectors: Rows) -> list[float]:
    return [*map(math.hypot, *vectors.T.tolist())]


class Level:
    """The rows of a level, at least one, and what several metrics need of them.

    The reference is the pose at which the level starts, above the target; it is the path too, but
    where a route is followed: there the path is the piece of the route that is due.
    """

    def __init__(self, rows: Rows) -> None:
        self.rows = rows
        self.dt = round(time(rows) / max(len(rows) - 1, 1), 9)  # [s]

    @cached_property
    def contacts(self) -> Mapping[str, float]:
        """What `contacts` returns."""
        return contacts(self.rows)

    @cached_property
    def position(self) -> Mapping[str, float]:
        """What `position_error` returns."""
        return position_error(self.rows, self._start())

    @cached_property
    def path(self) -> Mapping[str, float]:
        """What `path_following` returns."""
        if has_route(self.rows.shape[1]):
            return path_errors(self.rows[:, ROUTE_INDEX["cross_track"]].tolist(), self.dt)
        return path_following(self.rows, [self._start()], self.dt)

    @cached_property
    def tracked(self) -> Mapping[str, float]:
        """What `euclidean_norm` returns."""
        return euclidean_norm(self.rows)

    @cached_property
    def centred(self) -> Mapping[str, float]:
        """What `object_centered_on_cam` returns."""
        return object_centered_on_cam(self.rows)

    def _start(self) -> Point:
        x, y, z = self.rows[0, INDEX["x"] : INDEX["z"] + 1].tolist()
        return x, y, z


def _collision_over_run(_name: str, levels: Levels) -> float | None:
    steps, mean_speed, max_speed = over_run(CONTACTS, levels).values()
    if steps is None or mean_speed is None or max_speed is None:
        return None
    return collision(steps=steps, mean_speed=mean_speed, max_speed=max_speed)


_metric = partial(LevelMetric, better="lower")
CONTACTS: tuple[LevelMetric[Level], ...] = (
    _metric(
        name="contactTicks",
        label="Control steps in contact",
        unit="",
        formula="control steps with a contact force",
        over=SUM,
        reads=("contact_n",),
        compute=lambda level: level.contacts["steps"],
    ),
    _metric(
        name="contactSpeedMean",
        label="Mean speed in contact",
        unit="m/s",
        formula="mean speed over ground during contact; 0 without any",
        over=weighted_by("contactTicks"),
        reads=_CONTACT_COLUMNS,
        compute=lambda level: level.contacts["mean_speed"],
    ),
    _metric(
        name="contactSpeedMax",
        label="Maximum speed in contact",
        unit="m/s",
        formula="maximum speed over ground during contact; 0 without any",
        over=MAX,
        reads=_CONTACT_COLUMNS,
        compute=lambda level: level.contacts["max_speed"],
    ),
)
METRICS: tuple[LevelMetric[Level], ...] = (
    _metric(
        name="time",
        label="Simulated time",
        unit="s",
        formula="control steps times dt, simulated",
        over=SUM,
        reads=("t",),
        compute=lambda level: time(level.rows) + level.dt,  # the last row is a whole control step
    ),
    LevelMetric(
        name="collision",
        label="Collision: 1 without any",
        unit="",
        better="higher",
        formula="max(0, 1 - (contactSpeedMean + contactSpeedMax) / "
        f"{COLLISION_SPEED_M_S:g} m/s); 1 without contact",
        over=Aggregation("the formula with the values over the run", _collision_over_run),
        reads=_CONTACT_COLUMNS,
        compute=lambda level: collision(**level.contacts),
    ),
    *CONTACTS,
    _metric(
        name="positionError",
        label="Mean distance from the reference position",
        unit="m",
        formula="mean distance from the position at which the level starts",
        reads=_POSITION,
        compute=lambda level: level.position["total"],
    ),
    _metric(
        name="positionErrorX",
        label="Mean error along north",
        unit="m",
        formula="mean absolute error along north",
        reads=_POSITION,
        compute=lambda level: level.position["x"],
    ),
    _metric(
        name="positionErrorY",
        label="Mean error along east",
        unit="m",
        formula="mean absolute error along east",
        reads=_POSITION,
        compute=lambda level: level.position["y"],
    ),
    _metric(
        name="positionErrorZ",
        label="Mean error along down",
        unit="m",
        formula="mean absolute error along down",
        reads=_POSITION,
        compute=lambda level: level.position["z"],
    ),
    _metric(
        name="positionErrorAngle",
        label="Mean angle from the reference attitude",
        unit="rad",
        formula="mean angle of the rotation from the attitude at which the level starts",
        reads=ANGLES,
        compute=lambda level: attitude_error(level.rows),
    ),
    _metric(
        name="distance",
        label="Travelled distance",
        unit="m",
        formula="sum of the distances between control steps; the reset between levels not counted",
        over=SUM,
        reads=(*_POSITION, "level"),
        compute=lambda level: distance(level.rows),
    ),
    _metric(
        name="corners",
        label="Tracked corners to true corners, norm of all eight numbers",
        unit="px",
        formula="mean norm of all eight numbers of (tracked - true corners), control steps with a "
        "tracked target",
        over=weighted_by("seenTicks"),
        reads=LOST_COLUMNS,
        compute=lambda level: level.tracked["corners"],
    ),
    _metric(
        name="centroid",
        label="Tracked centre to true centre",
        unit="px",
        formula="mean norm of (tracked - true centre), control steps with a tracked target",
        over=weighted_by("seenTicks"),
        reads=("tracker_ok", "tracked_x", "tracked_y", "target_x", "target_y"),
        compute=lambda level: level.tracked["centroid"],
    ),
    LevelMetric(
        name="seenTicks",
        label="Control steps with a tracked target",
        unit="",
        better="higher",
        formula="control steps at which the tracker reports the target",
        over=SUM,
        reads=("tracker_ok",),
        compute=lambda level: float((level.rows[:, INDEX["tracker_ok"]] == 1.0).sum()),
    ),
    _metric(
        name="objectCenteredOnCam",
        label="Target to image centre",
        unit="px",
        formula="mean distance of the true target from the image centre",
        reads=_CENTRED,
        compute=lambda level: level.centred["total"],
    ),
    _metric(
        name="objectCenteredOnCamX",
        label="Target to image centre along X",
        unit="px",
        formula="mean absolute distance along image X",
        reads=_CENTRED,
        compute=lambda level: level.centred["x"],
    ),
    _metric(
        name="objectCenteredOnCamY",
        label="Target to image centre along Y",
        unit="px",
        formula="mean absolute distance along image Y",
        reads=_CENTRED,
        compute=lambda level: level.centred["y"],
    ),
    _metric(
        name="pathFollowingIAE",
        label="Integral of the distance to the path",
        unit="m s",
        formula="sum of the distance to the path, times dt",
        over=SUM,
        reads=(*_POSITION, "t"),
        compute=lambda level: level.path["iae"],
    ),
    _metric(
        name="pathFollowingISE",
        label="Integral of the squared distance to the path",
        unit="m² s",
        formula="sum of the squared distance to the path, times dt",
        over=SUM,
        reads=(*_POSITION, "t"),
        compute=lambda level: level.path["ise"],
    ),
    _metric(
        name="distanceToPath",
        label="Mean distance to the path",
        unit="m",
        formula="mean distance to the path",
        reads=_POSITION,
        compute=lambda level: level.path["distanceToPath"],
    ),
)
NAMES = tuple(metric.name for metric in METRICS)
GROUP = MetricGroup("The original benchmark module", METRICS)


def level_metrics(rows: Rows, *, absent: Absent = frozenset()) -> dict[str, float | None]:
    """Return all metrics of one level by name; nan where there is none."""
    if not len(rows):
        return dict.fromkeys(NAMES, math.nan)
    return compute_all(METRICS, Level(rows), absent=absent)
