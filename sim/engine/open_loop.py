"""The open loop of one level: a prescribed path, so the tracker cannot influence its images."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.camera import Camera
from seamark.sim.engine.tracker_in_loop import TrackerInLoop
from seamark.sim.engine.tracking_error import write_tracking_error
from seamark.sim.recording.telemetry import INDEX, STEP_US, WIDTH, OnRows, Recorder

_TIME = slice(INDEX["trial"], INDEX["t"] + 1)
_MOTION = slice(INDEX["x"], INDEX["r"] + 1)
Row = NDArray[np.float64]


class Path(Protocol):
    """Where the vehicle is at any time."""

    def pose_and_velocity(self, t: float) -> tuple[Sequence[float], Sequence[float]]:
        """Return the pose (6) [m, rad], world frame, and the velocity (6), body frame."""


class Timing(Protocol):
    """The settings of time that a level needs."""

    @property
    def control_period_s(self) -> float:
        """Time from one image to the next."""

    @property
    def level_duration_s(self) -> float:
        """Time from the start of a level to that of the next."""

    @property
    def control_steps_per_level(self) -> int:
        """Number of images of a level."""


class OpenLoop:
    """Runs one level image by image; telemetry of parts that are not simulated stays 0."""

    def __init__(
        self,
        config: Timing,
        path: Path,
        camera: Camera,
        tracking: TrackerInLoop,
        *,
        station: NDArray[np.float64],
        trial: int,
        level: int,
        start_every: int = 0,
    ) -> None:
        """Set up a level.

        Parameters
        ----------
        start_every
            Images from one start of the tracker to the next; 0: the first one starts it for good.
        station : (6,) [m, rad]
            Pose from which the camera looks at the target's centre.
        """
        self._path, self._camera, self._tracking = path, camera, tracking
        self._trial, self._level = trial, level
        self._steps, self._dt = config.control_steps_per_level, config.control_period_s
        self._start_every = start_every or self._steps
        self._first_frame = level * self._steps
        self._start_s = level * config.level_duration_s
        self._station = camera.position(station)

    def run(self, on_rows: OnRows) -> None:
        """Run the level; rows go to `on_rows`, the last ones even if the tracker raises."""
        recorder = Recorder(on_rows, width=WIDTH)
        try:
            for step in range(self._steps):
                self.step(step, recorder.next_row())
                recorder.commit()
        finally:
            recorder.flush()

    def motion(self, step: int) -> NDArray[np.float64]:
        """Return pose and velocity, (12,), at an image of the level, and what else moves."""
        own = np.concatenate(self._path.pose_and_velocity(step * self._dt))
        return self._camera.at(own, self.frame(step))

    def starts(self, step: int) -> bool:
        """Return whether the tracker is started at this image rather than asked."""
        return step % self._start_every == 0

    def frame(self, step: int) -> int:
        """Return the number of an image in the trial; the noise of its pixels depends on it."""
        return self._first_frame + step

    def step(self, step: int, row: Row) -> None:
        """Start the tracker or give it the image, and fill the row."""
        tracking, motion = self._tracking, self.motion(step)
        track = tracking.start if self.starts(step) else tracking.update
        track(motion, self.frame(step))
        row[:] = 0.0
        row[_TIME] = self._trial, self._level, self._start_s + step * self._dt
        row[_MOTION] = motion[:12]
        write_tracking_error(
            motion, tracking.corners, tracking.ok, tracking.target_view, self._station, row
        )
        row[STEP_US] = tracking.step_us

    def close(self) -> None:
        """Do nothing: this loop holds no resources."""
