"""When trackers other than the template tracker report a loss: the same rules for all.

The template tracker has these rules in its compiled code (sim/trackers/template/frame_step.py).
"""

import numpy as np

from seamark.sim.trackers.interface import Corners
from seamark.sim.trackers.options import LARGEST_JUMP
from seamark.sim.trackers.template.frame_step import MAX_AREA_RATIO
from seamark.sim.trackers.template.warps import is_convex, signed_area


class PlausibilityGate:
    """Accepts or rejects corners by comparing them with the last accepted ones."""

    def __init__(self, corners: Corners, *, max_jump: float = LARGEST_JUMP) -> None:
        """Start from true corners (4, 2) [px].

        Parameters
        ----------
        max_jump : float
            Largest plausible motion of a corner from one image to the next, in multiples of the
            longer side at the start.

        Raises
        ------
        ValueError
            They are not a convex quadrilateral.
        """
        corners = np.array(corners, dtype=np.float64, order="C")
        if corners.shape != (4, 2) or not is_convex(corners):
            raise ValueError(
                "the target's corners are not a convex quadrilateral (4, 2) in clockwise order"
            )
        self.last = corners
        self._area = float(signed_area(corners))
        sides = np.sqrt(((corners - np.roll(corners, 1, axis=0)) ** 2).sum(axis=1))
        self._jump = max_jump * float(sides.max())

    def accept(self, corners: Corners) -> bool:
        """Return whether these corners are plausible; if so, they become the last ones."""
        corners = np.array(corners, dtype=np.float64, order="C")
        if not np.isfinite(corners).all() or not is_convex(corners):
            return False
        ratio = float(signed_area(corners)) / self._area
        if not 1.0 / MAX_AREA_RATIO <= ratio <= MAX_AREA_RATIO:
            return False
        if float(np.abs(corners - self.last).max()) > self._jump:
            return False
        self.last = corners
        return True
