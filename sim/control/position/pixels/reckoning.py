"""Where the target is: by what the eye saw last, and by dead reckoning since then."""

from collections import deque
from collections.abc import Mapping
from typing import Any, NamedTuple

from seamark.sim.camera.optics import MOUNT_M
from seamark.sim.control.observation import Observation
from seamark.sim.numerics.libm import sincos
from seamark.sim.physics.constants import TARGET_HEIGHT_M

LEARN = 0.3  # E: share of a new sight in what is remembered
STEPS = 12  # control steps that are remembered, more than an image is late
BELOW_CAMERA_M = MOUNT_M[2] + TARGET_HEIGHT_M.scalar  # from the body's origin to the top
Plane = tuple[float, float]  # forward and starboard, or north and east


class Moment(NamedTuple):
    """The vehicle at a control step."""

    t: float  # [s]
    place: Plane  # [m] north and east of where the level began
    attitude: tuple[float, float, float]  # [rad]
    height: float  # [m] of the camera above the target


class Reckoning:
    """Remembers where the target is, north and east of where the level began.

    An image is compared with the attitude and the place that the vehicle had when it was taken.
    """

    def __init__(self, config: Mapping[str, Any]) -> None:
        self.focal_px = config["camera_focal_px"]
        self.reset()

    def reset(self) -> None:
        """Begin a level."""
        self.place: Plane = (0.0, 0.0)
        self.target: Plane | None = None
        self.moments: deque[Moment] = deque(maxlen=STEPS)

    def move(self, observation: Observation) -> None:
        """Take the observation of a control step."""
        o = observation
        roll, pitch, yaw = o.attitude.tolist()
        if self.moments:
            surge, sway, heave = o.velocity.tolist()
            north, east = self._turned(yaw, self._level((surge, sway, heave), roll, pitch))
            self.place = self.place[0] + north * o.dt, self.place[1] + east * o.dt
        height = o.altitude - BELOW_CAMERA_M
        self.moments.append(Moment(o.t, self.place, (roll, pitch, yaw), height))

    def see(self, image_t: float, sight: tuple[float, float]) -> None:
        """Take where the target was in an image, relative to its centre [px]."""
        taken = min(self.moments, key=lambda moment: abs(moment.t - image_t))
        roll, pitch, yaw = taken.attitude
        right, aft = (each / self.focal_px for each in sight)
        x, y, z = self._levelled((-aft, right, 1.0), roll, pitch)
        mount = self._level(MOUNT_M, roll, pitch)
        ahead, side = mount[0] + taken.height * x / z, mount[1] + taken.height * y / z
        north, east = self._turned(yaw, (ahead, side))
        seen = taken.place[0] + north, taken.place[1] + east
        if self.target is None:
            self.target = seen
        else:
            known = self.target
            self.target = (
                known[0] + LEARN * (seen[0] - known[0]),
                known[1] + LEARN * (seen[1] - known[1]),
            )

    def error(self) -> Plane:
        """Return how far the camera has to move, forward and starboard [m]; 0 before any sight."""
        if self.target is None:
            return 0.0, 0.0
        roll, pitch, yaw = self.moments[-1].attitude
        off = self.target[0] - self.place[0], self.target[1] - self.place[1]
        ahead, side = self._turned(-yaw, off)
        mount = self._level(MOUNT_M, roll, pitch)
        return ahead - mount[0], side - mount[1]

    def _turned(self, angle: float, vector: Plane) -> Plane:
        sine, cosine = sincos(angle)
        x, y = vector
        return cosine * x - sine * y, sine * x + cosine * y

    def _level(self, vector: tuple[float, float, float], roll: float, pitch: float) -> Plane:
        x, y, _z = self._levelled(vector, roll, pitch)
        return x, y

    def _levelled(
        self, vector: tuple[float, float, float], roll: float, pitch: float
    ) -> tuple[float, float, float]:
        """Return a vector of the body along level axes: ahead, starboard, down."""
        x, y, z = vector
        sin_roll, cos_roll = sincos(roll)
        sin_pitch, cos_pitch = sincos(pitch)
        side, down = cos_roll * y - sin_roll * z, sin_roll * y + cos_roll * z
        return cos_pitch * x + sin_pitch * down, side, cos_pitch * down - sin_pitch * x
