"""What a tracker is: it is shown pictures and says where the target is."""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Corners = NDArray[np.float64]  # (4, 2) [px], in reading order of the target's letters
Window = tuple[int, int, int, int]  # x0, y0, x1, y1 [px], the last column and row not included


class Track(NamedTuple):
    """What a tracker says about one picture."""

    corners: Corners
    ok: bool  # the tracker's own opinion; False: `corners` is where it last was sure
    residual: float  # 0 perfect ... 1 nothing alike ... 2 the opposite
    iterations: int


class Tracker(Protocol):
    """Follows one target from picture to picture."""

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Learn the target from a whole picture (H, W) in which its corners are known."""
        ...

    def window(self) -> Window:
        """Return which part of the next picture is needed; an empty one if none is."""
        ...

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Find the target in the next picture (H, W), of which only `window()` need be drawn."""
        ...
