"""When trackers that are not our own kernel have to call themselves lost: the same rules for all.

The template tracker has these rules in its compiled code (sim/trackers/template/frame_step.py).
"""

import numpy as np

from seamark.sim.trackers.interface import Corners
from seamark.sim.trackers.template.frame_step import LARGEST_AREA_RATIO, LARGEST_JUMP
from seamark.sim.trackers.template.warps import is_convex, signed_area


class Judge:
    """Keeps the last place that was believed, and says whether the next one can be."""

    def __init__(self, corners: Corners) -> None:
        """Start from true corners (4, 2) [px].

        Raises
        ------
        ValueError
            If they are no convex quadrilateral.
        """
        corners = np.array(corners, dtype=np.float64, order="C")
        if corners.shape != (4, 2) or not is_convex(corners):
            raise ValueError("the target's corners are no convex quadrilateral (4, 2) clockwise")
        self.last = corners
        self._area = float(signed_area(corners))
        sides = np.sqrt(((corners - np.roll(corners, 1, axis=0)) ** 2).sum(axis=1))
        self._jump = LARGEST_JUMP * float(sides.max())

    def believes(self, corners: Corners) -> bool:
        """Return whether these corners can be the target's; if so, they are the last ones now."""
        corners = np.array(corners, dtype=np.float64, order="C")
        if not np.isfinite(corners).all() or not is_convex(corners):
            return False
        ratio = float(signed_area(corners)) / self._area
        if not 1.0 / LARGEST_AREA_RATIO <= ratio <= LARGEST_AREA_RATIO:
            return False
        if float(np.abs(corners - self.last).max()) > self._jump:
            return False
        self.last = corners
        return True
