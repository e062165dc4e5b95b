"""The newest image of each vehicle of a fleet: taken, late and rendered as for a program.

See `sim/engine/images_in_loop.py`, which does so for one vehicle.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.camera import Camera
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.survey import Survey
from seamark.sim.fleet.tables import Progress
from seamark.sim.fleet.views import Pencils, draw_all, lend_camera, pencils_for, survey_all
from seamark.sim.numerics.arrays import Array, Flags, Integers

InThreads = Callable[..., None]


class ImageKind(NamedTuple):
    """What the images of a fleet are like."""

    optics: Optics
    channels: tuple[int, ...]  # 0 red, 1 green, 2 blue; the grey image of trackers is the green one
    drawn: bool  # whether what the camera sees is wanted
    surveyed: bool  # whether depth and labels of the pixels are wanted


class FleetImages:
    """The newest image of each vehicle, and with what it is drawn."""

    def __init__(self, count: int, kind: ImageKind, *, every: int, slots: int) -> None:
        """Set up.

        Parameters
        ----------
        every
            Control steps from one image to the next.
        slots
            Control steps by which an image is late at most, and one more.
        """
        height, width = kind.optics.height, kind.optics.width
        channels = kind.channels
        self.newest: NDArray[np.uint8] = np.zeros((count, height, width, len(channels)), np.uint8)
        self.surveys: Survey | None = None  # (n, height, width) each
        if kind.surveyed:
            shape = (count, height, width)
            self.surveys = Survey(np.zeros(shape, np.float32), np.zeros(shape, np.uint8))
        self._channels, self._every, self._drawn = channels, every, kind.drawn
        self._motions = np.zeros((slots, count, 12))
        self._frames = np.zeros((slots, count), np.int64)
        self._vehicles = np.arange(count)
        self._cameras: list[Camera | None] = [None] * count  # what is lent has to live on
        self._pencils: Pencils | None = None

    def place(self, i: int, camera: Camera) -> None:
        """Give a vehicle the camera of its next level."""
        if self._pencils is None:
            self._pencils = pencils_for(len(self._cameras), camera, self._channels)
        self._cameras[i] = camera
        lend_camera(self._pencils, i, camera, self._channels)

    def changing(self) -> dict[str, NDArray[Any]]:
        """Return what steps change, by name: views, whose first index is the vehicle."""
        surveys = self.surveys._asdict() if self.surveys is not None else {}
        under_way = {"motions": self._motions.swapaxes(0, 1), "frames": self._frames.T}
        return {"newest": self.newest} | surveys | under_way

    def step(
        self,
        chosen: Flags,
        motions: Array,
        frames: Integers,
        progress: Progress,
        in_threads: InThreads,
    ) -> None:
        """Render what arrives now for the chosen vehicles (n,); the others keep their images.

        Parameters
        ----------
        motions : (n, 12)
            Where they are now, as `Camera` has it.
        frames : (n,)
            Number of the present image.
        in_threads
            Calls a compiled function for parts of the vehicles.
        """
        now = progress.step[chosen] % len(self._motions), self._vehicles[chosen]
        self._motions[now], self._frames[now] = motions[chosen], frames[chosen]
        taken = progress.step - progress.late[:, 0]
        new = (progress.step == 0) | ((taken > 0) & (taken % self._every == 0))
        then: Any = (np.maximum(taken, 0) % len(self._motions), self._vehicles)
        if (chosen & new).any():
            moved, numbers = self._motions[then], self._frames[then]
            if self._drawn:
                in_threads(draw_all, chosen & new, moved, numbers, self._pencils, self.newest)
            if self.surveys is not None:
                in_threads(survey_all, chosen & new, moved, self._pencils, self.surveys)
