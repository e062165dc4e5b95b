"""`box`: an axis-aligned box, moved to where its pixels correlate best (OpenCV): a baseline.

Compared with KCF and CSRT it does not learn, so it never drifts; it has sub-pixel resolution and
takes a hundredth of their time. OpenCV's MIL is not offered: its random generator cannot be seeded,
so the same run would not give the same bytes.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Corners, Track, Window
from seamark.sim.trackers.plausibility import PlausibilityGate
from seamark.sim.trackers.subpixel import peak_offset

LOWEST_CORRELATION = 0.5  # E: as for the template tracker
SMALLEST_PX = 6


class BoxTracker:
    """Moves the target's corners with an axis-aligned box of constant size."""

    def __init__(self, *, search_px: int = 20) -> None:
        self._search = search_px
        self._shape = (0, 0)

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Learn the box around the corners (4, 2) of a whole image (H, W)."""
        self._gate = PlausibilityGate(corners)
        self._shape = image.shape
        low = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
        high = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, image.shape[::-1])
        if (high - low).min() < SMALLEST_PX:
            raise ValueError("the target is too small or outside the image")
        self._template = image[low[1] : high[1], low[0] : high[0]].copy()
        self._start, self._position = low, low
        self._corners = self._gate.last.copy()

    def window(self) -> Window:
        """Return the box and the search margin around it, inside the image."""
        height, width = self._template.shape
        x, y = (int(value) for value in self._position)
        return (
            max(x - self._search, 0),
            max(y - self._search, 0),
            min(x + width + self._search, self._shape[1]),
            min(y + height + self._search, self._shape[0]),
        )

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Move the box to the best match in the next image (H, W)."""
        x0, y0, x1, y1 = self.window()
        matches = cv2.matchTemplate(image[y0:y1, x0:x1], self._template, cv2.TM_CCOEFF_NORMED)
        scores = np.nan_to_num(np.asarray(matches, dtype=np.float64))
        row, column = np.unravel_index(int(scores.argmax()), scores.shape)
        similarity = float(scores[row, column])
        position = np.array([x0 + column, y0 + row])
        fraction = np.array(
            [peak_offset(scores[row], int(column)), peak_offset(scores[:, column], int(row))]
        )
        ok = similarity >= LOWEST_CORRELATION
        ok = ok and self._gate.accept(self._corners + (position - self._start) + fraction)
        if ok:
            self._position = position
        return Track(self._gate.last.copy(), ok, 1.0 - similarity, 1)
