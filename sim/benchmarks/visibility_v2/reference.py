"""Reference entries of visibility-v2: trackers that do not look, and the truth.

They are marks on the leaderboard that nobody can submit: what no skill gets, and what is possible.
"""

from enum import Enum

import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers import Track, Tracker, Window
from seamark.sim.trackers.interface import Corners

IMAGES_SEEN = 4  # by the blind tracker: 0.2 s


class Truth(Enum):
    """Stands for the true corners, which only a level knows."""

    ORACLE = "oracle"


class StillTracker:
    """Answers with the corners of the start for ever, without looking at any image."""

    def __init__(self) -> None:
        self._corners: Corners = np.zeros((4, 2))

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Remember the corners."""
        self._corners = corners.copy()

    def window(self) -> Window:
        """Return an empty window."""
        return 0, 0, 0, 0

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Return the corners of the start."""
        return Track(self._corners, True, 0.0, 0)


class BlindTracker:
    """Follows the target through the first images, then moves on at the velocity seen there."""

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker
        self._corners: Corners = np.zeros((4, 2))
        self._velocity: Corners = np.zeros((4, 2))  # [px] per image
        self._images = 0

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Start the tracker that looks at the first images."""
        self._tracker.start(image, corners)
        self._corners, self._images = corners.copy(), 0
        self._velocity = np.zeros((4, 2))

    def window(self) -> Window:
        """Return what the tracker needs as long as it looks; then an empty window."""
        return self._tracker.window() if self._images < IMAGES_SEEN else (0, 0, 0, 0)

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Return the corners: seen in the first images, extrapolated in all others."""
        self._images += 1
        corners = self._corners + self._velocity
        if self._images <= IMAGES_SEEN:
            track = self._tracker.update(image)
            if track.ok:
                corners = track.corners.copy()
                self._velocity = corners - self._corners
        self._corners = corners
        return Track(corners, True, 0.0, 0)
