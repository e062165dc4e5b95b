"""Rows of telemetry from a log: what it has, and what follows from pose and corners."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seamark.mission_logs.mapping import CORNERS, TRUE_CORNERS
from seamark.mission_logs.result import LogRefused
from seamark.mission_logs.samples import Values
from seamark.mission_logs.timeline import Timeline
from seamark.sim.camera.camera import Camera
from seamark.sim.camera.geometry import diagonal_intersection
from seamark.sim.engine.tracking_error import (
    BOX_CENTRE,
    TOP_CENTRE,
    TargetView,
    write_tracking_error,
)
from seamark.sim.recording.telemetry import INDEX, POSE_COLUMNS, Rows, width_for

# What `write_tracking_error` computes: from the pose alone, and from pose and corners.
_FROM_POSE = ("target_x", "target_y", "error_x_px", "error_y_px", "distance_px", "distance")
_FROM_CORNERS = ("tracked_x", "tracked_y")
_FROM_BOTH = ("tracker_error",)


@dataclass(frozen=True, kw_only=True)
class LogRows:
    """The rows of a log. `absent` are columns that it neither has nor implies; they are nan."""

    rows: Rows
    measured: tuple[str, ...]  # columns that the log has
    derived: tuple[str, ...]  # columns that follow from them
    absent: frozenset[str]


def log_rows(
    timeline: Timeline,
    values: Mapping[str, Values],
    *,
    camera: Camera,
    station: NDArray[np.float64],
    counted: str,
    thrusters: int,
) -> LogRows:
    """Return the rows of a log with values in the frames of the telemetry.

    Parameters
    ----------
    values
        Of the timeline, converted; a column that is there is kept as it is.
    camera
        That of the benchmark's scene.
    station : (3,) [m]
        Where the camera should be, NED.
    counted
        The setting `target_truth`: which point of the target counts.

    Raises
    ------
    LogRefused
        There is neither a pose nor corners.
    """
    given = {name: column for name, column in values.items() if name in INDEX}
    rows = np.full((len(timeline.t), width_for(thrusters)), np.nan)
    view = TargetView(*camera.view(), BOX_CENTRE if counted == "uwsim" else TOP_CENTRE)
    derived = _derive(rows, values, camera=camera, view=view, station=station)
    for name, column in given.items():
        rows[:, INDEX[name]] = column
    rows[:, INDEX["t"]] = timeline.t
    for name in ("trial", "level"):
        if name not in given:
            rows[:, INDEX[name]] = 0.0
    known = {*given, *derived, "t", "trial", "level"}
    return LogRows(
        rows=rows,
        measured=tuple(name for name in INDEX if name in given),
        derived=tuple(name for name in INDEX if name in set(derived) - given.keys()),
        absent=frozenset(INDEX) - known,
    )


def _derive(
    rows: Rows,
    values: Mapping[str, Values],
    *,
    camera: Camera,
    view: TargetView,
    station: NDArray[np.float64],
) -> set[str]:
    """Write what follows from pose and corners, and return the names of these columns."""
    poses, corners = _block(values, POSE_COLUMNS), _block(values, CORNERS)
    truth = _block(values, TRUE_CORNERS)
    if poses is None and corners is None and truth is None:
        raise LogRefused(
            "The log has neither a whole pose (x, y, z, roll, pitch, yaw or a quaternion) nor "
            "the four corners of the target (corner_0 to corner_7), so nothing can be measured."
        )
    derived: set[str] = set()
    if poses is not None:
        _write_views(rows, poses, corners, view=view, station=station)
        derived |= set(_FROM_POSE) | (set() if corners is None else set(_FROM_BOTH))
    if truth is not None:
        _write_truth(rows, truth, corners, camera)
        derived |= set(_FROM_POSE) - {"distance"} | (set() if corners is None else set(_FROM_BOTH))
    if corners is not None:
        rows[:, INDEX["tracked_x"] : INDEX["tracked_y"] + 1] = _centres(corners)
        rows[:, INDEX["tracker_ok"]] = np.isfinite(corners).all(axis=1)
        derived |= {*_FROM_CORNERS, "tracker_ok"}
    return derived


def _block(values: Mapping[str, Values], names: tuple[str, ...]) -> NDArray[np.float64] | None:
    """Return some columns side by side, (n, k); None if one is missing."""
    if not set(names) <= values.keys():
        return None
    return np.ascontiguousarray(np.stack([values[name] for name in names], axis=1))


def _write_views(
    rows: Rows,
    poses: NDArray[np.float64],
    corners: NDArray[np.float64] | None,
    *,
    view: TargetView,
    station: NDArray[np.float64],
) -> None:
    """Write what the simulator writes for a pose; without corners the tracker's part stays nan."""
    nothing = np.full(8, np.nan)
    for at, row in enumerate(rows):
        seen = nothing if corners is None else corners[at]
        write_tracking_error(poses[at], seen, False, view, station, row)


def _write_truth(
    rows: Rows,
    truth: NDArray[np.float64],
    corners: NDArray[np.float64] | None,
    camera: Camera,
) -> None:
    """Write what follows from the true corners in the image, which count more than the pose."""
    centres = _centres(truth)
    off = centres - np.array(camera.optics.principal_px)
    for name, column in (
        *zip(("target_x", "target_y"), centres.T, strict=True),
        *zip(("error_x_px", "error_y_px"), off.T, strict=True),
        ("distance_px", np.sqrt(off[:, 0] * off[:, 0] + off[:, 1] * off[:, 1])),
    ):
        rows[:, INDEX[name]] = column
    if corners is not None:
        off = corners - truth
        rows[:, INDEX["tracker_error"]] = np.sqrt(0.25 * (off * off).sum(axis=1))


def _centres(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where the diagonals of each quadrilateral meet, (n, 2)."""
    return np.array([diagonal_intersection(one) for one in corners])
