"""Single jumps of the camera, each of a prescribed size in the image: the convergence basin.

The pose jumps in all six coordinates, so that the target's image is displaced, turned, scaled and
tilted as a vehicle can make it.
"""

from collections.abc import Sequence

import numpy as np

from seamark.sim.benchmarks.visibility_v2.scenario import Scenario, displacement
from seamark.sim.camera.camera import Camera

# Standard deviations of the coordinates [m, rad], before a jump is scaled to its size: each alone
# displaces the corners at 1.27 m by about the same; D.
SPREADS = (0.005, 0.005, 0.03, 0.004, 0.004, 0.023)
SCALINGS = 20  # the size is then exact to a hundredth of a pixel, mostly to far less


class Jumps:
    """Pairs of poses: from the station to where the next jump ends."""

    def __init__(
        self,
        scenario: Scenario,
        camera: Camera,
        size_px: float,
        *,
        level: int,
        count: int,
        image_period_s: float,
    ) -> None:
        """Draw the jumps of one level, each displacing the corners by `size_px` (RMS)."""
        random = np.random.Generator(np.random.PCG64([scenario.jumps_seed, level]))
        self._station = list(scenario.station)
        self._camera, self._period_s = camera, image_period_s
        directions = (random.standard_normal((count, 6)) * SPREADS).tolist()
        self._poses = [self._scaled(direction, size_px) for direction in directions]

    def pose_and_velocity(self, t: float) -> tuple[list[float], list[float]]:
        """Return the station, or every second image the pose after the next jump; at rest."""
        image = round(t / self._period_s)
        return self._poses[image // 2] if image % 2 else self._station, [0.0] * 6

    def _scaled(self, direction: Sequence[float], size_px: float) -> list[float]:
        before = self._corners(self._station)
        factor = 1.0
        pose = self._station
        for _ in range(SCALINGS):
            pose = [a + factor * b for a, b in zip(self._station, direction, strict=True)]
            factor *= size_px / displacement(before, self._corners(pose))
        return [a + factor * b for a, b in zip(self._station, direction, strict=True)]

    def _corners(self, pose: Sequence[float]) -> list[float]:
        corners: list[float] = self._camera.corners(np.array(pose)).ravel().tolist()
        return corners
