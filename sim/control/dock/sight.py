"""Where a vehicle is against its dock, by acoustic answers, lamps and marker."""

import math
from collections.abc import Mapping
from pkgutil import resolve_name
from typing import Any

from seamark.sim.control.observation import Observation
from seamark.sim.control.track.navigation import Measured, Navigation

AXES = (0, 1)
FARTHEST_M = 20.0  # E: of a start
MARKER_GAIN, LIGHT_GAIN = 0.15, 0.05  # E: of each image
FRESH_S = 2.0  # E: since the last image, for which acoustic answers are not asked
LEVEL_GAIN = 0.02  # E: of each reading of the altimeter


class DockSight:
    """Position of the vehicle north and east of its seat, and above it [m].

    The filter of routes has the seat as its origin: an answer of the dock is then a fix. An image
    of the marker or of the lamps says more; it moves the position by a share of the difference.
    """

    def __init__(self, config: Mapping[str, Any], *, looks: bool = True, fixes: int | None = None):
        """Set up for a level; `fixes` is how many answers are used, None for all."""
        self._config, self._looks, self._fixes = config, looks, fixes
        self._navigation = Navigation(FARTHEST_M)
        self._sincos = resolve_name("seamark.sim.numerics.libm:sincos")
        self._focal = config["camera_focal_px"]
        self._camera_m = config["camera_mount_m"][2]
        self._rails_m, self._marker_m = config["rails_m"], config["marker_m"][2]
        self._seat_depth: float | None = None
        self._asked_at = -1.0
        self.known = False  # whether anything has been heard or seen of the dock
        self.seen_s = math.inf  # since the marker was seen
        self.position = (0.0, 0.0)
        self.above_m = math.inf
        self.yaw = (0.0, 1.0)

    def update(self, observation: Observation) -> None:
        """Take the observation of a step."""
        self.yaw = self._sincos(observation.attitude.item(2))
        seat = observation.depth + observation.altitude - self._rails_m - self._camera_m
        before = self._seat_depth
        self._seat_depth = seat if before is None else before + LEVEL_GAIN * (seat - before)
        self.above_m = self._seat_depth - observation.depth
        self._navigation.update(self._measured(observation))
        self.seen_s += observation.dt
        if self._looks:
            self._look(observation)
        north, east = self._navigation.position
        self.position = (north, east)

    def _measured(self, observation: Observation) -> Measured:
        age, (north, east, _down) = observation.dock_age, observation.dock.tolist()
        if age >= 0.0:
            self.known = True
        asked_at = observation.t - age
        if age >= 0.0 and asked_at > self._asked_at + 0.5 * observation.dt:
            self._asked_at = asked_at
            if self._fixes is not None:
                self._fixes -= 1
        unused = self._fixes is not None and self._fixes < 0
        speeds = observation.velocity.tolist()
        return Measured(
            t=observation.t,
            dt=observation.dt,
            speeds=(speeds[0], speeds[1]),
            depth=observation.depth,
            yaw=self.yaw,
            fix=(-north, -east),
            fix_age=-1.0 if unused or self.seen_s < FRESH_S else age,
            fix_sigma=observation.dock_sigma,
            pipe=(0.0, 0.0),
        )

    def _look(self, observation: Observation) -> None:
        sine, cosine = self.yaw
        ahead, side, gain = 0.0, 0.0, 0.0
        if observation.target_visible:
            ahead, side, _down = observation.error.tolist()
            gain, self.seen_s = MARKER_GAIN, 0.0
        elif observation.light_visible and self.seen_s > FRESH_S:
            ahead, side = self._to_lamps(observation)
            gain = LIGHT_GAIN
        if gain:
            self.known = True
            place = self._navigation.position
            for axis, off in zip(
                AXES, (cosine * ahead - sine * side, sine * ahead + cosine * side), strict=True
            ):
                place[axis] += gain * (-off - place[axis])

    def _to_lamps(self, observation: Observation) -> tuple[float, float]:
        """Return how far the lamps are ahead and to starboard [m], by the height above them."""
        right, aft = (pixels / self._focal for pixels in observation.light.tolist())
        roll, pitch, _yaw = observation.attitude.tolist()
        height = max(self.above_m + self._rails_m - self._marker_m, 0.1)
        return -height * (aft - pitch), height * (right - roll)
