"""The tracker in the loop: it gets the part of the image that it needs; its result is kept."""

import time

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.camera import Camera
from seamark.sim.engine.sight import Sight
from seamark.sim.engine.tracking_error import TOP_CENTRE, TargetView
from seamark.sim.numerics.random_streams import Streams
from seamark.sim.settings.tracker import TrackerSettings
from seamark.sim.trackers import Tracker, make
from seamark.sim.trackers.template.tracker import TemplateTracker

Pose = NDArray[np.float64]  # (6,); (12,) with the velocities, for motion blur


class Untracked:
    """What is known of the target over one level without a tracker: nothing."""

    def __init__(self, camera: Camera, target: int = TOP_CENTRE) -> None:
        """Take the camera; `target` as in `TargetView` counts as the target's true position."""
        self._camera = camera
        self._corners = np.zeros((4, 2))
        self.corners = self._corners.reshape(8)  # [px] last valid ones; a view of the same memory
        self.ok = False  # whether the tracker reports the target in the present image
        self.target_view = TargetView(*camera.view(), target)
        self.step_us = 0.0  # wall time of the tracker's last update; never part of a result

    def start(self, pose: Pose, frame: int) -> None:
        """Take the pose of the first image."""
        self._camera.follow(pose)

    def update(self, pose: Pose, frame: int) -> None:
        """Take the pose of the next image."""
        self._camera.follow(pose)

    def sight(self) -> Sight | None:
        """Return tracker and camera for compiled loops, which then call no `update`.

        None unless it is a template tracker, which has started, that follows a target at rest in
        the images of a vehicle without an arm.
        """
        return None


class TrackerInLoop(Untracked):
    """One tracker over one level."""

    def __init__(
        self,
        camera: Camera,
        settings: TrackerSettings,
        start_error: NDArray[np.float64],
        *,
        tracker: Tracker | None = None,
        reference: Camera | None = None,
        target: int = TOP_CENTRE,
    ) -> None:
        """Set up the given tracker, or else the configured one.

        Parameters
        ----------
        start_error : (4, 2) [px]
            Added to the corners that the tracker starts from.
        reference
            Takes the first image, from which the tracker learns the target, instead of `camera`.
        target
            The point that counts as the target's true position, as in `TargetView`.
        """
        super().__init__(camera, target)
        self._reference = reference or camera
        self._start_error = start_error
        self._pose: Pose = np.zeros(6)
        self.tracker = tracker or self._configured(settings)

    def sight(self) -> Sight | None:  # noqa: D102 - as above
        camera, tracker = self._camera, self.tracker
        if type(camera) is not Camera or not isinstance(tracker, TemplateTracker):
            return None
        return Sight(camera.pencil(), tracker.memory())

    def _configured(self, settings: TrackerSettings) -> Tracker:
        options = settings.tracker_options()
        return make(settings.tracker, truth=lambda: self._camera.corners(self._pose), **options)

    def start(self, pose: Pose, frame: int) -> None:
        """Start the tracker with the first image and the target's corners in it."""
        self._pose = pose
        self._camera.follow(pose)
        corners = self._camera.corners(pose) + self._start_error
        self.tracker.start(self._reference.grey(pose, frame), corners)
        self._corners[:] = corners
        self.ok = True

    def update(self, pose: Pose, frame: int) -> None:
        """Give the tracker the next image and keep its result."""
        self._pose = pose
        self._camera.follow(pose)
        image = self._camera.region(pose, frame, self.tracker.window())
        before = time.perf_counter_ns()
        track = self.tracker.update(image)
        self.step_us = (time.perf_counter_ns() - before) * 1e-3
        self.ok = track.ok
        if track.ok:
            self._corners[:] = track.corners


def draw_start_error(sigma_px: float, random: Streams) -> NDArray[np.float64]:
    """Return the error (4, 2) [px] of the corners that the tracker of a level starts from.

    These are the first numbers of their stream, which must be fresh.
    """
    error: NDArray[np.float64] = sigma_px * random.start.standard_normal((4, 2))
    return error
