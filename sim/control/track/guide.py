"""The point of a route to steer for: ahead of the nearest one, by what the vehicle knows."""

import math

import numpy as np

from seamark.sim.control.track.navigation import Measured, Navigation
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.polyline import at_length, nearest, starts_of

WINDOW_M = 1.0  # E: in which the nearest point is looked for, so that no part is skipped


class Guide:
    """Goes along a route with the vehicle.

    The point where the vehicle has got to goes on along the route, never back, and never farther
    than a window at once, since parts of a route may come near each other.

    Attributes
    ----------
    position : (3,) [m]
        North and east by `Navigation`, and depth.
    along_m : float
        How far along the route the vehicle has got.
    here, aim : (6,)
        Where the vehicle has got to on the route, and the point to steer for: position [m] and
        direction of the route.
    """

    def __init__(
        self, route: Array, lookahead_m: float, start_error_m: float, *, fixes: bool = True
    ) -> None:
        """Begin at the first point of a route, (k, 3) [m]; `fixes` as of `Navigation`."""
        self._route, self._starts = route, starts_of(route)
        self.lookahead_m = lookahead_m
        self._navigation = Navigation(start_error_m, fixes=fixes)
        self._places = np.empty((0, 6))  # on the route, a way of one control step apart
        self.along_m = 0.0
        self.position, self.here, self.aim = np.zeros(3), np.zeros(6), np.zeros(6)

    @property
    def left_m(self) -> float:
        """How much of the route is left [m]."""
        return float(self._starts[-1]) - self.along_m

    def update(self, now: Measured) -> None:
        """Take the measurements of a step."""
        self._navigation.update(now)
        self.position[:] = *self._navigation.position, now.depth
        last = min(self.along_m + WINDOW_M, float(self._starts[-1]))
        self.along_m, _off = nearest(
            self._route, self._starts, self.position, self.along_m, last, self.here
        )
        at_length(self._route, self._starts, self.along_m + self.lookahead_m, self.aim)

    def ahead(self, way_m: float, steps: int) -> Array:
        """Return the places ahead on the route, each `way_m` from the last, (steps, 6).

        Both are the same in all calls. Beyond the end it is the end.
        """
        if not len(self._places):
            count = int(float(self._starts[-1]) / way_m) + 3 + steps
            self._places = np.empty((count, 6))
            for i in range(count):
                at_length(self._route, self._starts, i * way_m, self._places[i])
        first, share = divmod(self.along_m / way_m, 1.0)
        here = self._places[int(first) + 1 :]
        ahead: Array = (1.0 - share) * here[:steps] + share * here[1 : steps + 1]
        return ahead

    def to_aim(self) -> tuple[float, float, float, float]:
        """Return the way to the point to steer for: north, east, down and its length [m]."""
        north, east, down = (self.aim[:3] - self.position).tolist()
        return north, east, down, math.sqrt(north * north + east * east + down * down)
