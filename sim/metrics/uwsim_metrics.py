"""The measures of the original benchmark module (uwsimbenchmarks), from telemetry rows.

Same definitions; where the original is wrong, the corrected one is here. `docs/measures.md` has all
formulas and names each error.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from seamark.sim.metrics.metric import Metric
from seamark.sim.numerics.statistics import mean
from seamark.sim.recording.telemetry import INDEX, Rows

COLLISION_SPEED_M_S = 0.5  # S: uwsimbenchmarks, the speed at which a collision costs all
Points = Sequence[tuple[float, float, float]]
Column = NDArray[np.float64]  # (k,)
Turn = tuple[Column, Column]  # sine and cosine
ANGLES = ("roll", "pitch", "yaw")
MEASURES: tuple[Metric, ...] = (
    Metric("time", "Simulated time", "s", "lower", "sum"),
    Metric("collision", "Collision: 1 without any", "", "higher"),
    Metric("contactTicks", "Control ticks in contact", "", "lower", "sum"),
    Metric("contactSpeedMean", "Mean speed in contact", "m/s", "lower"),
    Metric("contactSpeedMax", "Greatest speed in contact", "m/s", "lower", "max"),
    Metric("positionError", "Mean distance from the wanted place", "m", "lower"),
    Metric("positionErrorX", "Mean error along north", "m", "lower"),
    Metric("positionErrorY", "Mean error along east", "m", "lower"),
    Metric("positionErrorZ", "Mean error along down", "m", "lower"),
    Metric("positionErrorAngle", "Mean angle from the wanted attitude", "rad", "lower"),
    Metric("distance", "Travelled distance", "m", "lower", "sum"),
    Metric("corners", "Tracked corners to true corners, norm of all eight numbers", "px", "lower"),
    Metric("centroid", "Tracked centre to true centre", "px", "lower"),
    Metric("seenTicks", "Control ticks with a tracked target", "", "higher", "sum"),
    Metric("objectCenteredOnCam", "Target to image centre", "px", "lower"),
    Metric("objectCenteredOnCamX", "Target to image centre along X", "px", "lower"),
    Metric("objectCenteredOnCamY", "Target to image centre along Y", "px", "lower"),
    Metric("pathFollowingIAE", "Integral of the distance to the path", "m s", "lower", "sum"),
    Metric("pathFollowingISE", "Integral of its square", "m² s", "lower", "sum"),
    Metric("distanceToPath", "Mean distance to the path", "m", "lower"),
)
NAMES = tuple(measure.name for measure in MEASURES)
SUMS = tuple(measure.name for measure in MEASURES if measure.over == "sum")


def time(rows: Rows) -> float:
    """Return the simulated time from the first row to the last [s]."""
    t = _column(rows, "t")
    return t[-1] - t[0] if t else math.nan


def contacts(rows: Rows) -> dict[str, float]:
    """Return the number of ticks in contact, and mean and greatest speed [m/s] during them."""
    touching = rows[rows[:, INDEX["contact_n"]] > 0.0]
    speeds = _lengths(touching[:, INDEX["u"] : INDEX["w"] + 1])
    return {
        "ticks": float(len(speeds)),
        "mean_speed": mean(speeds) if speeds else 0.0,
        "max_speed": max(speeds, default=0.0),
    }


def collision(*, ticks: float, mean_speed: float, max_speed: float) -> float:
    """Return 1 for no collision, down to 0, from what `contacts` gives."""
    if not ticks:
        return 1.0
    return max(0.0, 1.0 - (mean_speed + max_speed) / COLLISION_SPEED_M_S)


def position_error(rows: Rows, target: tuple[float, float, float]) -> dict[str, float]:
    """Return mean distance from a place, NED, and the mean size of each axis's error [m]."""
    off = rows[:, INDEX["x"] : INDEX["z"] + 1] - np.array(target)
    axes = {axis: mean(np.abs(off[:, i]).tolist()) for i, axis in enumerate("xyz")}
    return {"total": mean(_lengths(off))} | axes


def attitude_error(rows: Rows) -> float:
    """Return the mean angle [rad] by which the vehicle is turned from how the level starts."""
    rotation = _rotation(*(_sine_and_cosine(_column(rows, name)) for name in ANGLES))
    # The trace of the rotation between two attitudes is 1 + 2 cos(angle).
    trace = sum(entry * entry[0] for entry in rotation)
    cosines = np.clip(0.5 * (trace - 1.0), -1.0, 1.0)
    return mean([math.acos(cosine) for cosine in cosines.tolist()])


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
    """Return IAE [m s], ISE [m² s] and mean distance [m] to a path of one or more points, NED."""
    places = rows[:, INDEX["x"] : INDEX["z"] + 1]
    if len(path) == 1:
        off = _lengths(places - np.array(path[0]))
    else:
        pieces = list(pairwise(path))
        off = [min(_to_piece(place, *piece) for piece in pieces) for place in places.tolist()]
    return {
        "iae": math.fsum(off) * dt,
        "ise": math.fsum(value * value for value in off) * dt,
        "distanceToPath": mean(off),
    }


def of_level(rows: Rows) -> dict[str, float]:
    """Return all measures of one level by name; nan where there is none.

    Wanted is the pose at which the level starts, above the target; it is the path too.
    """
    if not len(rows):
        return dict.fromkeys(NAMES, math.nan)
    dt = round(time(rows) / max(len(rows) - 1, 1), 9)
    start = rows[0, INDEX["x"] : INDEX["z"] + 1].tolist()
    place = (start[0], start[1], start[2])
    wanted, followed = position_error(rows, place), path_following(rows, [place], dt)
    seen, centred, hit = euclidean_norm(rows), object_centered_on_cam(rows), contacts(rows)
    return {
        "time": time(rows) + dt,  # the last row stands for a whole tick
        "collision": collision(**hit),
        "contactTicks": hit["ticks"],
        "contactSpeedMean": hit["mean_speed"],
        "contactSpeedMax": hit["max_speed"],
        "positionError": wanted["total"],
        "positionErrorX": wanted["x"],
        "positionErrorY": wanted["y"],
        "positionErrorZ": wanted["z"],
        "positionErrorAngle": attitude_error(rows),
        "distance": distance(rows),
        "corners": seen["corners"],
        "centroid": seen["centroid"],
        "seenTicks": float((rows[:, INDEX["tracker_ok"]] == 1.0).sum()),
        "objectCenteredOnCam": centred["total"],
        "objectCenteredOnCamX": centred["x"],
        "objectCenteredOnCamY": centred["y"],
        "pathFollowingIAE": followed["iae"],
        "pathFollowingISE": followed["ise"],
        "distanceToPath": followed["distanceToPath"],
    }


def of_run(levels: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the measures over all levels of a trial, from those of each."""
    whole = {name: mean([level[name] for level in levels]) for name in NAMES}
    for name in SUMS:
        whole[name] = math.fsum(level[name] for level in levels)
    for name in ("corners", "centroid"):
        whole[name] = _weighted(levels, name, "seenTicks")
    whole["contactSpeedMean"] = _weighted(levels, "contactSpeedMean", "contactTicks")
    whole["contactSpeedMax"] = max((level["contactSpeedMax"] for level in levels), default=0.0)
    whole["collision"] = collision(
        ticks=whole["contactTicks"],
        mean_speed=whole["contactSpeedMean"],
        max_speed=whole["contactSpeedMax"],
    )
    return whole


def _weighted(levels: Sequence[Mapping[str, float]], name: str, weight: str) -> float:
    """Return the mean over all rows that count, where a level without any has none."""
    found = [(level[name], level[weight]) for level in levels if level[weight]]
    total = math.fsum(count for _, count in found)
    return math.fsum(value * count for value, count in found) / total if total else math.nan


def _to_piece(place: Sequence[float], start: Sequence[float], end: Sequence[float]) -> float:
    along = [b - a for a, b in zip(start, end, strict=True)]
    off = [p - a for a, p in zip(start, place, strict=True)]
    square = math.fsum(value * value for value in along)
    share = math.fsum(a * b for a, b in zip(along, off, strict=True)) / square if square else 0.0
    share = min(max(share, 0.0), 1.0)
    return math.dist(off, [share * value for value in along])


def _sine_and_cosine(angles: Sequence[float]) -> tuple[Column, Column]:
    return np.array([math.sin(a) for a in angles]), np.array([math.cos(a) for a in angles])


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
    return [math.hypot(*vector) for vector in vectors.tolist()]
