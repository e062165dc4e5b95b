"""`truth`: a perfect tracker, for studies of controllers without tracking errors."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Corners, Track, Window


class TruthTracker:
    """Returns the true corners for every image, without reading a pixel of it."""

    def __init__(self, *, truth: Callable[[], Corners]) -> None:
        self._truth = truth
        self._last = np.zeros((4, 2))
        self._shape = (0, 0)

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Remember where the target starts and how large the image is."""
        self._last, self._shape = np.array(corners, dtype=np.float64), image.shape

    def window(self) -> Window:
        """Return an empty window."""
        return 0, 0, 0, 0

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Return the true corners; not `ok` while the target's centre is outside the image."""
        corners = np.asarray(self._truth(), dtype=np.float64)
        middle = corners.mean(axis=0)
        height, width = self._shape
        ok = bool(0 <= middle[0] <= width - 1 and 0 <= middle[1] <= height - 1)
        if ok:
            self._last = corners.copy()
        return Track(self._last.copy(), ok, 0.0 if ok else 1.0, 0)
