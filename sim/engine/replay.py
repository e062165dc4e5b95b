"""Pictures of a run, made again from its telemetry: each is a pure function of a row and the seed.

So no video is ever stored, and a data set can be made of any run whose seed is known.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim import registry
from seamark.sim.camera.camera import Camera
from seamark.sim.engine.tracker_in_loop import start_error_of
from seamark.sim.numerics.random_streams import streams
from seamark.sim.recording.telemetry import INDEX
from seamark.sim.settings.configuration import Configuration

Picture = NDArray[np.uint8]
Row = NDArray[np.float64]

_MOTION = slice(INDEX["x"], INDEX["r"] + 1)
_CAMERAS = 12  # kept; each is one level's


@dataclass(frozen=True, slots=True)
class Shot:
    """What the camera saw at one row of the telemetry."""

    camera: Camera
    pose: Row  # (12,) x, y, z [m], roll, pitch, yaw [rad], u, v, w [m/s], p, q, r [rad/s]
    frame: int  # number of the picture in the trial

    def grey(self) -> Picture:
        """Return the picture (H, W) that the tracker had."""
        return self.camera.grey(self.pose, self.frame)

    def colour(self) -> Picture:
        """Return the picture (H, W, 3) in blue, green, red, for people."""
        return self.camera.colour(self.pose, self.frame)

    def corners(self) -> Row:
        """Return the true corners (4, 2) [px] of the target's top face."""
        return self.camera.corners(self.pose)


class Replay:
    """The pictures of one configuration; `seed_of` gives the seed of a trial."""

    def __init__(
        self, benchmark: str, config: Configuration, seed_of: Callable[[int], int]
    ) -> None:
        experiment = registry.benchmark(benchmark).load()
        settings: Any = config
        self._level_s, self._dt = settings.level_duration_s, settings.control_period_s
        self._ticks = settings.control_steps_per_level

        @lru_cache(maxsize=_CAMERAS)
        def camera(trial: int, level: int) -> Camera:
            made: Camera = experiment.camera(
                settings, seed=seed_of(trial), trial=trial, level=level
            )
            return made

        def first_camera(trial: int, level: int) -> Camera:
            made: Camera = experiment.first_camera(
                settings, seed=seed_of(trial), trial=trial, level=level
            )
            return made

        def start_error(trial: int, level: int) -> Row:
            return start_error_of(settings, streams(seed_of(trial), trial, level))

        self.camera = camera
        self._first_camera, self._start_error = first_camera, start_error

    def shot(self, row: Row) -> Shot:
        """Return what the camera saw at a row of the telemetry, (WIDTH,)."""
        trial, level = place_of(row)
        tick = round((float(row[INDEX["t"]]) - level * self._level_s) / self._dt)
        pose = np.ascontiguousarray(row[_MOTION])
        return Shot(self.camera(trial, level), pose, level * self._ticks + tick)

    def first(self, row: Row) -> tuple[Shot, Row]:
        """Return what a level's first row was to its tracker.

        Returns
        -------
        Shot
            The picture from which the tracker learned the target; its water may be another than
            the level's.
        (4, 2) [px]
            The corners that it was told: the true ones and the configured error of the start.
        """
        trial, level = place_of(row)
        shot = self.shot(row)
        learned = Shot(self._first_camera(trial, level), shot.pose, shot.frame)
        return learned, shot.corners() + self._start_error(trial, level)


def place_of(row: Row) -> tuple[int, int]:
    """Return trial and level of a row."""
    return int(row[INDEX["trial"]]), int(row[INDEX["level"]])
