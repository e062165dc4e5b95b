"""Single jumps of vehicle and target, each of a prescribed size in the image.

Both jump: the vehicle in all six coordinates and the target over the bottom, so that the target's
image is displaced by both, and that of the bottom by the vehicle alone.
"""

from collections.abc import Sequence

import numpy as np

from seamark.sim.benchmarks.visibility_v2.jumps import SCALINGS, SPREADS
from seamark.sim.benchmarks.visibility_v2.scenario import displacement
from seamark.sim.benchmarks.visibility_v3.scenario import Scenario, camera_of
from seamark.sim.benchmarks.visibility_v3.settings import VisibilityConfiguration

# Standard deviations of the target's own jump [m, m, rad]: E, as far in the image as the vehicle's.
OWN_SPREADS = (0.01, 0.01, 0.023)


class Jumps:
    """Pairs of poses and places: from the start to where the next jump ends."""

    def __init__(
        self, config: VisibilityConfiguration, scenario: Scenario, size_px: float, *, level: int
    ) -> None:
        """Draw the jumps of one level, each displacing the corners by `size_px` (RMS)."""
        scene, target = scenario.scene, scenario.scene.target
        random = np.random.Generator(np.random.PCG64([scene.jumps_seed, level]))
        self._start = [*scene.station, target.north_m, target.east_m, target.heading_rad]
        self._camera = camera_of(scene, config, 0.0, self)
        self._period_s = config.control_period_s
        count = config.control_steps_per_level // config.images_per_start(level)
        directions = (random.standard_normal((count, 9)) * (*SPREADS, *OWN_SPREADS)).tolist()
        self._ends = [self._scaled(direction, size_px) for direction in directions]

    def pose_and_velocity(self, t: float) -> tuple[list[float], list[float]]:
        """Return the vehicle's pose: the station, or every second image after a jump; at rest."""
        return self._at(t)[:6], [0.0] * 6

    def place_and_rate(self, t: float) -> tuple[list[float], list[float]]:
        """Return the target's north, east and heading likewise."""
        return self._at(t)[6:], [0.0] * 3

    def _at(self, t: float) -> list[float]:
        image = round(t / self._period_s)
        return self._ends[image // 2] if image % 2 else self._start

    def _scaled(self, direction: Sequence[float], size_px: float) -> list[float]:
        before = self._corners(self._start)
        factor = 1.0
        for _ in range(SCALINGS):
            factor *= size_px / displacement(before, self._corners(self._moved(direction, factor)))
        return self._moved(direction, factor)

    def _moved(self, direction: Sequence[float], factor: float) -> list[float]:
        return [a + factor * b for a, b in zip(self._start, direction, strict=True)]

    def _corners(self, at: Sequence[float]) -> list[float]:
        pose = np.array([*at[:6], *[0.0] * 6, *at[6:], *[0.0] * 3])
        corners: list[float] = self._camera.corners(pose).ravel().tolist()
        return corners
