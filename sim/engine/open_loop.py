"""One level on a prescribed path: the tracker sees pictures on which it has no influence."""

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.camera import Camera
from seamark.sim.engine.experiment import OnRows
from seamark.sim.engine.prescribed_path import Path
from seamark.sim.engine.tracker_in_loop import Tracking
from seamark.sim.engine.tracking_error import judge
from seamark.sim.recording.telemetry import INDEX, STEP_US, Recorder
from seamark.sim.settings.experiment import ExperimentSettings

_KNOWN = slice(INDEX["trial"], INDEX["t"] + 1)
_MOVING = slice(INDEX["x"], INDEX["r"] + 1)


class PathLoop:
    """Runs one level picture by picture; what has no part in it stays 0 in the telemetry."""

    def __init__(
        self,
        config: ExperimentSettings,
        path: Path,
        camera: Camera,
        tracking: Tracking,
        *,
        station: NDArray[np.float64],
        place: tuple[int, int],
    ) -> None:
        """Set up a level.

        Parameters
        ----------
        station : (6,) [m, rad]
            Pose from which the camera looks at the target's middle.
        place
            Trial and level.
        """
        self._path, self._tracking = path, tracking
        self._trial, self._level = place
        self._ticks, self._dt = config.control_steps_per_level, config.control_period_s
        self._began = self._level * config.level_duration_s
        self._station = camera.place(station)

    def run(self, recorder: Recorder, on_rows: OnRows) -> None:
        """Run the level; rows go to `on_rows` whenever the recorder is full."""
        first = self._level * self._ticks
        for tick in range(self._ticks):
            row = recorder.next_row()
            pose, velocity = self._path.at(tick * self._dt)
            moving = np.array([*pose, *velocity])
            tracking = self._tracking
            look = tracking.update if tick else tracking.start
            look(moving, first + tick)
            row[:] = 0.0
            row[_KNOWN] = self._trial, self._level, self._began + tick * self._dt
            row[_MOVING] = moving
            judge(moving, tracking.corners, tracking.ok, tracking.view, self._station, row)
            row[STEP_US] = tracking.step_us
            if recorder.keep():
                on_rows(recorder.take())

    def close(self) -> None:
        """Nothing is held."""
