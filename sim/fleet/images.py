"""The newest image of each vehicle of a fleet: taken, late and rendered as for a program.

See `sim/engine/images_in_loop.py`, which does so for one vehicle.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.camera import Camera
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.survey import Survey
from seamark.sim.fleet.views import Image, Pencils, Shots, lend_camera, pencils_for


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
        self._channels, self._drawn, self._every = channels, kind.drawn, every
        self._motions = np.zeros((slots, count, 12))
        self._frames = np.zeros((slots, count), np.int64)
        self._copy: Image | None = None  # of the newest images, if a step made one
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

    def shown(self, *, copied: bool = False) -> tuple[Shots, Image | None, Survey | None]:
        """Return the last arguments of `views.show_all`, which is called now for all vehicles.

        Parameters
        ----------
        copied
            Whether it makes the next `copy`, of images that are still in the processor's cache.

        Raises
        ------
        LookupError
            No vehicle was ever placed.
        """
        if self._pencils is None:
            raise LookupError("a fleet without vehicles sees nothing")
        self._copy = np.empty_like(self.newest) if copied and self._drawn else None
        copies = self.newest[:0] if self._copy is None else self._copy
        shots = Shots(self._every, self._motions, self._frames, self._pencils, copies)
        return shots, self.newest if self._drawn else None, self.surveys

    def copy(self) -> Image:
        """Return a copy of the newest images."""
        made, self._copy = self._copy, None
        return self.newest.copy() if made is None else made
