"""`kcf` and `csrt`: OpenCV's correlation filters, which follow an upright box.

KCF (Henriques et al., PAMI 2015) neither turns nor grows its box; CSRT (Lukezic et al., IJCV 2018)
grows it. Both learn on with every picture and answer in whole pixels. The corners move and grow as
the box does, so a target that turns has an error of its own: baselines from tracking in the wild.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Corners, Track, Window
from seamark.sim.trackers.plausibility import Judge

SMALLEST_PX = 6


class _Filter(Protocol):
    """What OpenCV's trackers of boxes have in common: x, y, width and height [px] of the box."""

    def init(self, image: NDArray[np.uint8], box: Sequence[int], /) -> None: ...

    def update(self, image: NDArray[np.uint8], /) -> tuple[bool, Sequence[int]]: ...


class _BoxTracker(ABC):
    """Moves the target's corners with the box of a filter."""

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Learn the box around the corners (4, 2) of a whole picture (H, W)."""
        self._judge = Judge(corners)
        self._shape = image.shape
        low = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
        high = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, image.shape[::-1])
        if (high - low).min() < SMALLEST_PX:
            raise ValueError("the target is too small or outside the picture")
        self._low, self._size = low, high - low
        self._corners = self._judge.last.copy()
        self._filter = self._made()
        self._filter.init(_in_colours(image), (*low.tolist(), *self._size.tolist()))

    def window(self) -> Window:
        """Return the whole picture."""
        return 0, 0, self._shape[1], self._shape[0]

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Move the box to where the filter answers most in the next picture (H, W)."""
        try:
            sure, box = self._filter.update(_in_colours(image))
        except cv2.error:  # it throws where its box has left the picture
            return Track(self._judge.last.copy(), False, 1.0, 1)
        place = np.array(box, dtype=np.float64)
        grown = (self._corners - self._low) * (place[2:] / self._size)
        ok = bool(sure) and self._judge.believes(place[:2] + grown)
        return Track(self._judge.last.copy(), ok, 0.0 if ok else 1.0, 1)

    @abstractmethod
    def _made(self) -> _Filter:
        """Return a filter that has learnt nothing yet."""


class KcfTracker(_BoxTracker):
    """Kernelised correlation filter with OpenCV's own settings."""

    def _made(self) -> _Filter:
        made: _Filter = cv2.TrackerKCF.create()
        return made


class CsrtTracker(_BoxTracker):
    """Discriminative correlation filter with channel and spatial reliability, as OpenCV has it."""

    def _made(self) -> _Filter:
        made: _Filter = cv2.TrackerCSRT.create()
        return made


def _in_colours(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return three equal channels: OpenCV's KCF cannot go on with one (its issue 22203)."""
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
