"""Guidance along a pipe: from what a camera sees of it to the point to steer for."""

import math

import numpy as np

from seamark.sim.control.track.navigation import Measured, Navigation
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import PI, atan2, sincos

GAIN = 0.5  # E: of what an image says against what was known before it
GATE_M, GATE_RAD = 0.4, 0.6  # E: an image that says something farther off is not believed ...
GATE_M_S, GATE_RAD_S = 0.3, 0.2  # E: ... but the farther, the longer nothing was seen
_START = 2.0  # E: times these gates at first, since only the place of the start is known
Level = tuple[float, float]  # north and east, or ahead and to starboard


class Lens:
    """How a camera that looks down on a flat seabed maps it to its image."""

    def __init__(self, focal_px: float, mount_m: tuple[float, float, float]) -> None:
        self._focal, self._mount = focal_px, mount_m

    def on_seabed(self, pixel: Level, tilt: Level, altitude: float) -> Level:
        """Return where a pixel, right and down of the middle, is on the seabed: ahead, starboard.

        From the vehicle's origin [m], level; `tilt` is roll and pitch [rad], `altitude` that of the
        origin [m].
        """
        right, below = pixel
        ray = self._levelled((-below / self._focal, right / self._focal, 1.0), tilt)
        ahead, side, down = self._levelled(self._mount, tilt)
        far = (altitude - down) / max(ray[2], 1e-3)
        return ahead + far * ray[0], side + far * ray[1]

    @staticmethod
    def _levelled(vector: tuple[float, float, float], tilt: Level) -> tuple[float, float, float]:
        (sine, cosine), (fall, run) = map(sincos, tilt)
        x, y, z = vector
        side, down = cosine * y - sine * z, sine * y + cosine * z
        return run * x + fall * down, side, run * down - fall * x


class PipeLine:
    """The line on which the pipe is, as far as it was seen, in the frame of dead reckoning.

    What an image shows moves it by a share, if that can be the same pipe. While the pipe is under
    sand, it goes on straight.
    """

    def __init__(self, point: Level, heading: float) -> None:
        """Begin with a point, north and east [m], and the heading of the pipe there [rad]."""
        self.point, self.heading = point, heading
        self._seen_s: float | None = None  # when an image was last believed

    def look(self, t: float, point: Level, heading: float) -> None:
        """Take a point of the pipe and its heading, either way round, by the image of time `t`."""
        turn = heading - self.heading
        turn -= PI * math.floor(turn / PI + 0.5)
        sine, cosine = sincos(self.heading)
        north, east = point[0] - self.point[0], point[1] - self.point[1]
        off, ago = cosine * east - sine * north, t - (self._seen_s or 0.0)
        wide = _START if self._seen_s is None else 1.0
        if (
            abs(off) > wide * GATE_M + GATE_M_S * ago
            or abs(turn) > wide * GATE_RAD + GATE_RAD_S * ago
        ):
            return
        gain = 1.0 if self._seen_s is None else GAIN
        self._seen_s = t
        # From the foot of the new point on the old line.
        self.point = (point[0] + (1.0 - gain) * off * sine, point[1] - (1.0 - gain) * off * cosine)
        self.heading += gain * turn

    def beside(self, position: Level, yaw: float) -> tuple[float, float]:
        """Return offset [m] and angle [rad] of the pipe, as an observation has them."""
        sine, cosine = sincos(self.heading)
        north, east = self.point[0] - position[0], self.point[1] - position[1]
        angle = self.heading - yaw
        angle -= 2.0 * PI * math.floor(angle / (2.0 * PI) + 0.5)
        return cosine * east - sine * north, angle


class PipeGuide:
    """Goes along a pipe with the vehicle, as `guide.Guide` along a route that is known.

    It is told the length and the depth of the route; its direction is that of the pipe beside the
    vehicle, and how far it has got is the way that dead reckoning gives along it.
    """

    def __init__(self, route: Array, lookahead_m: float) -> None:
        """Begin at the first point of the told route, (k, 3) [m]."""
        self._length = float(np.sqrt(((route[-1] - route[0]) ** 2).sum()))
        self._depth = float(route[0, 2])
        self.lookahead_m = lookahead_m
        self._navigation = Navigation(0.0, fixes=False)
        self.along_m = 0.0
        self.position, self.here, self.aim = np.zeros(3), np.zeros(6), np.zeros(6)

    @property
    def left_m(self) -> float:
        """How much of the route is left [m]."""
        return self._length - self.along_m

    def update(self, now: Measured) -> None:
        """Take the measurements of a step."""
        self._navigation.update(now)
        offset, angle = now.pipe
        sine, cosine = sincos(atan2(*now.yaw) + angle)
        north, east = self._navigation.position
        on = (cosine * north + sine * east) - (cosine * self.position[0] + sine * self.position[1])
        self.along_m = min(max(self.along_m + on, 0.0), self._length)
        self.position[:] = north, east, now.depth
        self.here[:3] = north - offset * sine, east + offset * cosine, self._depth
        self.here[3:] = cosine, sine, 0.0
        self.aim[:] = self.here
        self.aim[:3] += min(self.lookahead_m, self.left_m) * self.here[3:]

    def ahead(self, way_m: float, steps: int) -> Array:
        """Return places straight ahead on the pipe as `guide.Guide` does on a route, (steps, 6)."""
        ahead = np.minimum(way_m * np.arange(1, steps + 1), self.left_m)
        out = np.tile(self.here, (steps, 1))
        out[:, :3] += ahead[:, None] * self.here[3:]
        return out

    def to_aim(self) -> tuple[float, float, float, float]:
        """Return the way to the point to steer for: north, east, down and its length [m]."""
        north, east, down = (self.aim[:3] - self.position).tolist()
        return north, east, down, math.sqrt(north * north + east * east + down * down)
