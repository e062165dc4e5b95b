"""The measures of the original benchmark module (uwsimbenchmarks), from telemetry rows.

Same names and definitions; where the original is wrong, the corrected one is here:

time
    Simulated seconds. The original takes wall time, so that a slow computer scored worse.
collision
    1 - sum of mean speeds / (ticks * 0.5) - greatest speed / 0.5, not below 0, over the ticks in
    contact. The original reads one body's speed twice.
positionError
    Distance to a wanted place, whole and by axis, mean over the rows.
distance
    Length of the path.
euclideanNorm
    Euclidean distance of tracked corners (all eight numbers) and centroid from the true ones, mean
    over the rows with the target. The original counts -1 for a failure, which lowers its mean.
objectCenteredOnCam
    Distance of the true target from the image centre, whole and by axis.
pathFollowing
    Distance to a path of straight pieces. What the original publishes as "ISE" adds distance times
    dt: it is the IAE and has that name here, beside the true ISE.

The original's triggers compare squared distances with 0.2 and 0.3, which makes them 0.45 m and
0.55 m; nothing here has a threshold.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from sim.statistics import mean
from sim.telemetry import INDEX, Rows

COLLISION_SPEED_M_S = 0.5  # S: uwsimbenchmarks, the speed at which a collision costs all
Points = Sequence[tuple[float, float, float]]


def time(rows: Rows) -> float:
    """Return the simulated time from the first row to the last [s]."""
    t = _column(rows, "t")
    return t[-1] - t[0] if t else math.nan


def collision(rows: Rows) -> float:
    """Return 1 for no collision, down to 0."""
    touching = rows[:, INDEX["contact_n"]] > 0.0
    speeds = _lengths(rows[touching, INDEX["u"] : INDEX["w"] + 1])
    if not speeds:
        return 1.0
    lost = math.fsum(speeds) / (len(speeds) * COLLISION_SPEED_M_S)
    return max(0.0, 1.0 - lost - max(speeds) / COLLISION_SPEED_M_S)


def position_error(rows: Rows, target: tuple[float, float, float]) -> dict[str, float]:
    """Return mean distance from a place, NED, and the mean size of each axis's error [m]."""
    off = rows[:, INDEX["x"] : INDEX["z"] + 1] - np.array(target)
    axes = {axis: mean(np.abs(off[:, i]).tolist()) for i, axis in enumerate("xyz")}
    return {"total": mean(_lengths(off))} | axes


def distance(rows: Rows) -> float:
    """Return the length of the path [m]; a level's start is no part of it."""
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
        "corners": 2.0 * mean(_column(seen, "tracker_error")),
        "centroid": mean(_lengths(off)),
    }


def object_centered_on_cam(rows: Rows) -> dict[str, float]:
    """Return the mean distance of the true target from the image centre, and by axis [px]."""
    return {
        "total": mean(_column(rows, "distance_px")),
        "x": mean([abs(value) for value in _column(rows, "error_x_px")]),
        "y": mean([abs(value) for value in _column(rows, "error_y_px")]),
    }


def path_following(rows: Rows, path: Points, dt: float) -> dict[str, float]:
    """Return IAE [m s], ISE [m² s] and mean distance [m] to a path of two or more points, NED."""
    if len(path) < 2:
        raise ValueError("a path has at least two points")
    places = rows[:, INDEX["x"] : INDEX["z"] + 1].tolist()
    pieces = list(pairwise(path))
    off = [min(_to_piece(place, start, end) for start, end in pieces) for place in places]
    return {
        "iae": math.fsum(off) * dt,
        "ise": math.fsum(value * value for value in off) * dt,
        "distanceToPath": mean(off),
    }


def named(rows: Rows) -> dict[str, float]:
    """Return the measures that need nothing but rows, by the names a score's expression uses."""
    centred = object_centered_on_cam(rows)
    return {
        "time": time(rows),
        "distance": distance(rows),
        "collision": collision(rows),
        "objectCenteredOnCam": centred["total"],
        **euclidean_norm(rows),
    }


def _to_piece(place: Sequence[float], start: Sequence[float], end: Sequence[float]) -> float:
    along = [b - a for a, b in zip(start, end, strict=True)]
    off = [p - a for a, p in zip(start, place, strict=True)]
    square = math.fsum(value * value for value in along)
    share = math.fsum(a * b for a, b in zip(along, off, strict=True)) / square if square else 0.0
    share = min(max(share, 0.0), 1.0)
    return math.dist(off, [share * value for value in along])


def _columns(*names: str) -> list[int]:
    return [INDEX[name] for name in names]


def _column(rows: Rows, name: str) -> list[float]:
    values: list[float] = rows[:, INDEX[name]].tolist()
    return values


def _lengths(vectors: Rows) -> list[float]:
    return [math.hypot(*vector) for vector in vectors.tolist()]
