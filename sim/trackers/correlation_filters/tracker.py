"""`kcf` and `csrt`: OpenCV's correlation filters, which track an axis-aligned box.

The box of KCF (Henriques et al., PAMI 2015) has a constant size, that of CSRT (Lukezic et al., IJCV
2018) scales; neither rotates. Both keep learning and have a resolution of one pixel. The corners
move and scale with the box, so a rotating target adds an error: baselines of general tracking.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Corners, Track, Window
from seamark.sim.trackers.plausibility import PlausibilityGate

SMALLEST_PX = 6


class BoxFilter(Protocol):
    """The interface of OpenCV's box trackers: x, y, width and height [px] of the box."""

    def init(self, image: NDArray[np.uint8], box: Sequence[int], /) -> object:
        """Learn the box in an image (H, W, 3)."""

    def update(self, image: NDArray[np.uint8], /) -> tuple[bool, Sequence[float]]:
        """Return whether the box is in the next image, and where."""


class UprightBoxTracker(ABC):
    """Moves the target's corners with the box of a filter."""

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Learn the box around the corners (4, 2) of a whole image (H, W)."""
        self._gate = PlausibilityGate(corners)
        self._shape = image.shape
        low = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
        high = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, image.shape[::-1])
        if (high - low).min() < SMALLEST_PX:
            raise ValueError("the target is too small or outside the image")
        self._low, self._size = low, high - low
        self._corners = self._gate.last.copy()
        self._filter = self._create_filter()
        self._filter.init(_as_bgr(image), (*low.tolist(), *self._size.tolist()))

    def window(self) -> Window:
        """Return the whole image."""
        return 0, 0, self._shape[1], self._shape[0]

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Move the box to the strongest response in the next image (H, W)."""
        try:
            tracked, box = self._filter.update(_as_bgr(image))
        except cv2.error:  # raised if its box has left the image
            return Track(self._gate.last.copy(), False, 1.0, 1)
        new = np.array(box, dtype=np.float64)
        scaled = (self._corners - self._low) * (new[2:] / self._size)
        ok = bool(tracked) and self._gate.accept(new[:2] + scaled)
        return Track(self._gate.last.copy(), ok, 0.0 if ok else 1.0, 1)

    @abstractmethod
    def _create_filter(self) -> BoxFilter:
        """Return a new filter."""


class KcfTracker(UprightBoxTracker):
    """Kernelised correlation filter with OpenCV's default settings."""

    def _create_filter(self) -> BoxFilter:
        made: BoxFilter = cv2.TrackerKCF.create()
        return made


class CsrtTracker(UprightBoxTracker):
    """Discriminative correlation filter with channel and spatial reliability."""

    def _create_filter(self) -> BoxFilter:
        made: BoxFilter = cv2.TrackerCSRT.create()
        return made


def _as_bgr(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return three equal channels: OpenCV's KCF fails with one (its issue 22203)."""
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
