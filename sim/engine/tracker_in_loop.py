"""The tracker in the loop: shows it what part of the picture it asks for, keeps its answer."""

import time

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.camera import Camera
from seamark.sim.engine.tracking_error import CENTRE, MIDDLE, View
from seamark.sim.numerics.random_streams import Streams
from seamark.sim.settings.experiment import ExperimentSettings
from seamark.sim.trackers import Tracker, make

Pose = NDArray[np.float64]  # (6,); (12,) with the velocities for motion blur


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
        self._pose: Pose = np.zeros(6)
        self._tracker = tracker or self._configured(config)
        self._corners = np.zeros((4, 2))
        self.corners = self._corners.reshape(8)  # [px] the last good ones; the same memory
        self.ok = False  # whether the tracker says that it has the target now
        target = MIDDLE if config.target_truth == "uwsim" else CENTRE
        self.view: View = (*camera.view(), target)
        self.step_us = 0.0  # wall time of the tracker's last answer; never part of a result

    def _configured(self, config: ExperimentSettings) -> Tracker:
        options = config.tracker_options()
        return make(config.tracker, truth=lambda: self._camera.corners(self._pose), **options)

    def start(self, pose: Pose, frame: int) -> None:
        """Show the first picture and tell where the target is in it."""
        self._pose = pose
        corners = self._camera.corners(pose) + self._start_error
        self._tracker.start(self._reference.grey(pose, frame), corners)
        self._corners[:] = corners
        self.ok = True

    def update(self, pose: Pose, frame: int) -> None:
        """Show the next picture and take over what the tracker makes of it."""
        self._pose = pose
        picture = self._camera.region(pose, frame, self._tracker.window())
        began = time.perf_counter_ns()
        track = self._tracker.update(picture)
        self.step_us = (time.perf_counter_ns() - began) * 1e-3
        self.ok = track.ok
        if track.ok:
            self._corners[:] = track.corners


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
