"""The interface of a tracker: it gets images and returns where the target is."""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Corners = NDArray[np.float64]  # (4, 2) [px], in reading order of the target's letters
Window = tuple[int, int, int, int]  # x0, y0, x1, y1 [px], the last column and row not included


class Track(NamedTuple):
    """The result of a tracker for one image."""

    corners: Corners
    ok: bool  # whether the tracker has the target; if not, `corners` are the last valid ones
    residual: float  # 0 perfect match, 1 no similarity, 2 inverted
    iterations: int


class Tracker(Protocol):
    """Follows one target from image to image."""

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Learn the target from a whole image (H, W) in which its corners are known."""
        ...

    def window(self) -> Window:
        """Return the part of the next image that is needed; may be empty."""
        ...

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Find the target in the next image (H, W), of which only `window()` is rendered."""
        ...
