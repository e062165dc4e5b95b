"""The tracker in the loop: shows it what part of the picture it asks for, keeps the truth.

"Lost" is decided by the tracker itself (`ok`) and, apart from it, by ground truth (`error_px`).
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sim.camera.camera import Camera
from sim.experiment_settings import ExperimentSettings
from sim.station_keeper import crossing
from sim.streams import Streams
from sim.trackers import Tracker, make

Pose = NDArray[np.float64]  # (6,)


@dataclass(slots=True)
class Seen:
    """What came of one picture; all in px."""

    corners: list[float] = field(default_factory=lambda: [0.0] * 8)  # the tracker's last good ones
    ok: bool = True
    error_px: float = 0.0  # root mean square distance of the four corners from the true ones
    target: tuple[float, float] = (0.0, 0.0)  # the true place
    camera_m: tuple[float, float, float] = (0.0, 0.0, 0.0)  # true place of the camera, NED


class Tracking:
    """One tracker over one level."""

    def __init__(
        self,
        camera: Camera,
        config: ExperimentSettings,
        start_error: NDArray[np.float64],
        *,
        tracker: Tracker | None = None,
        reference: Camera | None = None,
    ) -> None:
        """Set up the tracker: the given one, else the configured one.

        Parameters
        ----------
        start_error : (4, 2) [px]
            Added to its first corners.
        reference
            Takes the first picture, from which the tracker learns the target, in place of `camera`.
        """
        self._camera = camera
        self._reference = reference or camera
        self._start_error = start_error
        self._uwsim = config.target_truth == "uwsim"
        self._pose: Pose = np.zeros(6)
        self._tracker = tracker or self._configured(config)
        self._seen = Seen()
        self.step_us = 0.0  # wall time of the tracker's last answer; never part of a result

    def _configured(self, config: ExperimentSettings) -> Tracker:
        options = config.tracker_options()
        return make(config.tracker, truth=lambda: self._camera.corners(self._pose), **options)

    def start(self, pose: Pose, frame: int) -> Seen:
        """Show the first picture and tell where the target is in it."""
        self._pose = pose
        corners = self._camera.corners(pose) + self._start_error
        self._tracker.start(self._reference.grey(pose, frame), corners)
        self._seen.corners, self._seen.ok = corners.ravel().tolist(), True
        return self._judged(pose)

    def update(self, pose: Pose, frame: int) -> Seen:
        """Show the next picture and return what the tracker makes of it, beside the truth."""
        self._pose = pose
        picture = self._camera.region(pose, frame, self._tracker.window())
        began = time.perf_counter_ns()
        track = self._tracker.update(picture)
        self.step_us = (time.perf_counter_ns() - began) * 1e-3
        self._seen.ok = track.ok
        if track.ok:
            self._seen.corners = track.corners.ravel().tolist()
        return self._judged(pose)

    def _judged(self, pose: Pose) -> Seen:
        seen = self._seen
        true = self._camera.truth(pose)
        total = 0.0
        for a, b in zip(seen.corners, true[:8], strict=True):
            total += (a - b) * (a - b)
        seen.error_px = math.sqrt(0.25 * total)
        centroid_u, centroid_v, origin_u, origin_v, north, east, down = true[8:]
        seen.target = (origin_u, origin_v) if self._uwsim else (centroid_u, centroid_v)
        seen.camera_m = (north, east, down)
        return seen


def pictured(
    seen: Seen,
    error: Sequence[float],
    centre: tuple[float, float],
    station: Sequence[float],
) -> tuple[float, ...]:
    """Return the columns of the telemetry from `target_x` to `distance`.

    Parameters
    ----------
    error : (3,) [m]
        As the program saw it.
    centre [px]
        Principal point of the picture.
    station : (3,) [m]
        Where the camera should be, NED.
    """
    x, y, z = (a - b for a, b in zip(seen.camera_m, station, strict=True))
    off_x, off_y = seen.target[0] - centre[0], seen.target[1] - centre[1]
    return (
        *seen.target,
        *crossing(seen.corners),
        *seen.corners,
        *(seen.ok, seen.error_px),
        *error,
        *(off_x, off_y, math.sqrt(off_x * off_x + off_y * off_y)),
        math.sqrt(x * x + y * y + z * z),
    )


def tracking_of(
    config: ExperimentSettings,
    camera: Camera,
    random: Streams,
    *,
    tracker: Tracker | None = None,
    reference: Camera | None = None,
) -> Tracking:
    """Return the given or else the configured tracker, its start perturbed as configured."""
    error = start_error_of(config, random)
    return Tracking(camera, config, error, tracker=tracker, reference=reference)


def start_error_of(config: ExperimentSettings, random: Streams) -> NDArray[np.float64]:
    """Return by how much (4, 2) [px] the first corners of a level are off, as configured.

    The first numbers of their stream: it must be fresh.
    """
    error: NDArray[np.float64] = config.start_error_px * random.start.standard_normal((4, 2))
    return error
