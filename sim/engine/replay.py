"""Re-renders the images of a run from its telemetry: each is a function of one row and the seed.

So no video is ever stored, and a data set can be made of any run whose seed is known.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim import registry
from seamark.sim.camera.arm_camera import ArmCamera
from seamark.sim.camera.camera import Camera
from seamark.sim.engine.tracker_in_loop import draw_start_error
from seamark.sim.engine.vehicle_sonar import VehicleSonar, build_sonar
from seamark.sim.numerics.random_streams import streams
from seamark.sim.recording.telemetry import (
    ARM_INDEX,
    INDEX,
    SEARCH_INDEX,
    WORK_INDEX,
    Rows,
    has_arm,
    has_search,
    has_work,
)
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.grid import GridSettings
from seamark.sim.settings.sonar import SonarSettings

Image = NDArray[np.uint8]
Row = NDArray[np.float64]

_MOTION = slice(INDEX["x"], INDEX["r"] + 1)
_JOINTS = slice(ARM_INDEX["joint_0"], ARM_INDEX["joint_ref_0"])  # and their speeds
_WORK = slice(WORK_INDEX["workpiece_x"], WORK_INDEX["reach"])
_DECOY = slice(SEARCH_INDEX["decoy_x"], SEARCH_INDEX["decoy_arm_n"])
_FOUND = slice(SEARCH_INDEX["found_x0"], SEARCH_INDEX["found_confidence"])
_CACHED_CAMERAS = 12  # one per level


class NoCameraOnArm(Exception):
    """The vehicle has no arm, or there is no camera on it."""


class NoSonar(Exception):
    """The vehicle has no imaging sonar."""


@dataclass(frozen=True, slots=True)
class CameraFrame:
    """What the camera saw at one row of the telemetry."""

    camera: Camera
    # (12,) x, y, z [m], roll, pitch, yaw [rad], u, v, w [m/s], p, q, r [rad/s]; with an arm, its
    # joints and their speeds follow, where its workpiece is, and where the wrong one is; or where
    # a target is that moves by itself
    motion: Row
    number: int  # of the frame in the trial
    sonar: VehicleSonar | None = None

    def grey(self) -> Image:
        """Return the image (H, W) that the tracker had."""
        return self.camera.grey(self.motion, self.number)

    def colour(self) -> Image:
        """Return the image (H, W, 3) in blue, green, red, for people."""
        return self.camera.colour(self.motion, self.number)

    def on_arm(self) -> Image:
        """Return what the camera on the arm saw, (H, W, 3) in blue, green, red.

        Raises
        ------
        NoCameraOnArm
            There is no arm, or no camera on it.
        """
        image = None
        if isinstance(self.camera, ArmCamera):
            image = self.camera.colour_on_arm(self.motion, self.number)
        if image is None:
            raise NoCameraOnArm("The vehicle of this run has no camera on an arm.")
        return image

    def fan(self) -> Image:
        """Return what the sonar saw as a fan, (H, W, 3) in blue, green, red.

        Raises
        ------
        NoSonar
            There is none.
        """
        if self.sonar is None:
            raise NoSonar("The vehicle of this run has no imaging sonar.")
        return self.sonar.fan(self.motion, self.number)

    def corners(self) -> Row:
        """Return the true corners (4, 2) [px] of the target's top face."""
        return self.camera.corners(self.motion)

    def top_corners(self) -> Row:
        """Return where these corners are, (4, 3) [m] NED."""
        return self.camera.top_corners(self.motion)


class Replay:
    """The images of a run with one configuration; `seed_of` gives the seed of a trial."""

    def __init__(
        self, benchmark: str, config: Configuration, seed_of: Callable[[int], int]
    ) -> None:
        experiment = registry.benchmark(benchmark).load()
        settings: Any = config
        self._dt = settings.control_period_s

        @lru_cache(maxsize=_CACHED_CAMERAS)
        def camera(trial: int, level: int) -> Camera:
            built: Camera = experiment.camera(
                settings, seed=seed_of(trial), trial=trial, level=level
            )
            return built

        def first_camera(trial: int, level: int) -> Camera:
            built: Camera = experiment.first_camera(
                settings, seed=seed_of(trial), trial=trial, level=level
            )
            return built

        def start_error(trial: int, level: int) -> Row:
            return draw_start_error(settings.start_error_px, streams(seed_of(trial), trial, level))

        @lru_cache(maxsize=_CACHED_CAMERAS)
        def sonar(trial: int, level: int) -> VehicleSonar | None:
            if not isinstance(config, SonarSettings):
                return None
            here = config.for_trial(trial)
            if isinstance(here, GridSettings):
                here = here.at(level)
            return build_sonar(here, camera(trial, level), streams(seed_of(trial), trial, level))

        self.camera, self.sonar = camera, sonar
        self._first_camera, self._start_error = first_camera, start_error

    def frame(self, row: Row) -> CameraFrame:
        """Return what the camera saw at a row of the telemetry."""
        trial, level = trial_and_level(row)
        number = round(float(row[INDEX["t"]]) / self._dt)  # whatever the order of the levels
        motion = row[_MOTION]
        if has_arm(len(row)):
            motion = np.concatenate([motion, row[_JOINTS]])
        if has_work(len(row)):
            motion = np.concatenate([motion, row[_WORK]])
        if has_search(len(row)):
            motion = np.concatenate([motion, row[_DECOY]])
        camera, sonar = self.camera(trial, level), self.sonar(trial, level)
        return CameraFrame(camera, camera.at(np.ascontiguousarray(motion), number), number, sonar)

    def start(self, row: Row) -> tuple[CameraFrame, Row]:
        """Return what the tracker started from, given the row at which it did.

        Returns
        -------
        CameraFrame
            The frame from which the tracker learned the target; its water may differ from that of
            the level.
        (4, 2) [px]
            The corners it was given: the true ones plus the configured start error, or what a
            detector found.
        """
        trial, level = trial_and_level(row)
        frame = self.frame(row)
        if has_search(len(row)):  # what a detector found: the tracker starts in the image of it
            return frame, row[_FOUND].reshape(4, 2).copy()
        learned = CameraFrame(self._first_camera(trial, level), frame.motion, frame.number)
        return learned, frame.corners() + self._start_error(trial, level)


def starts_of(rows: Rows, every: int) -> Rows:
    """Return the rows of a level at which its tracker was started.

    That is the first one, and then every so many if it is not 0. Where the target has to be found
    first, it is whenever the tracker took over what a detector had found.
    """
    if not has_search(rows.shape[1]):
        return rows[:: every or len(rows)]
    corners = slice(INDEX["corner_0"], INDEX["corner_7"] + 1)
    took_over: Rows = rows[(rows[:, corners] == rows[:, _FOUND]).all(axis=1)]
    return took_over


def trial_and_level(row: Row) -> tuple[int, int]:
    """Return the trial and the level that a row belongs to."""
    return int(row[INDEX["trial"]]), int(row[INDEX["level"]])
