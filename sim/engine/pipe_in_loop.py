"""A pipe in the loop: a detector looks for it in images, and navigation carries on what it saw."""

from collections import deque
from typing import NamedTuple

from seamark.sim.camera.optics import Optics
from seamark.sim.camera.pipe_camera import PipeCamera
from seamark.sim.control.observation import STARTS
from seamark.sim.control.track.navigation import Measured, Navigation
from seamark.sim.control.track.pipe_guide import Lens, Level, PipeLine
from seamark.sim.detectors.pipe_edges import PipeEdges, PipeSeen
from seamark.sim.engine.delay import ImageDelay
from seamark.sim.engine.tracker_in_loop import Pose, Untracked
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import atan2, sincos

PERIOD_S = 0.2  # E: at 0.5 m/s an image each 0.1 m; an image costs the time of several steps
_SHOWN = 1.0  # E: half the length of the outline that is kept of a pipe, in its widths


class PipeInLoop(Untracked):
    """A detector of pipes over one level.

    Its answer is kept as the corners of a piece of the pipe around the point nearest to the middle
    of the image: left and right of one end, right and left of the other.
    """

    def __init__(self, camera: PipeCamera, *, altitude_m: float, step_s: float) -> None:
        """Set up for a camera that is to be so high above the top of the pipe."""
        super().__init__(camera)
        self.every = max(1, round(PERIOD_S / step_s))
        self._step, radius = -1, camera.pipe.radius_m
        width_px = 2.0 * radius * camera.optics.focal_px / (altitude_m + radius)
        self._detector = PipeEdges(width_px)

    def start(self, pose: Pose, frame: int) -> None:
        """Look for the pipe in the first image."""
        self.update(pose, frame)

    def update(self, pose: Pose, frame: int) -> None:
        """Look for the pipe in the next image, if it is time."""
        self._step += 1
        if self._step % self.every == 0:
            seen = self._detector.find(self._camera.grey(pose, frame))
            self.ok = seen.found
            if seen.found:
                self._corners[:] = _piece(seen)


def _piece(seen: PipeSeen) -> list[tuple[float, float]]:
    """Return the corners of a piece of a pipe in an image [px]."""
    (x, y), half = seen.direction, 0.5 * seen.width
    length = _SHOWN * seen.width
    return [
        (seen.u + end * length * x - side * half * y, seen.v + end * length * y + side * half * x)
        for end, side in ((1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0))
    ]


class _Taken(NamedTuple):
    """What the vehicle measured when an image was taken."""

    t: float  # [s]
    position: Level  # [m] north and east by dead reckoning
    yaw: float  # [rad]
    tilt: Level  # [rad] roll and pitch
    altitude: float  # [m]


class PipeReport:
    """Where the pipe is beside the vehicle, by images and dead reckoning."""

    def __init__(self, pipe: PipeInLoop, seen: ImageDelay, optics: Optics, *, late: int) -> None:
        """Take the detector and its answers, which are `late` control steps old."""
        self._seen, self._every, self._late = seen, pipe.every, late
        self._lens, self._centre = Lens(optics.focal_px, optics.mount_m), optics.principal_px
        self._taken: deque[_Taken] = deque(maxlen=late + 1)
        self._navigation = Navigation(0.0, fixes=False)
        self._line: PipeLine | None = None

    def begin(self, heading: float) -> None:
        """Take the heading [rad] with which the pipe is said to begin, below the vehicle."""
        self._line = PipeLine((0.0, 0.0), heading)

    def beside(self, step: int, now: Measured, observation: Array) -> tuple[float, float]:
        """Return offset [m] and angle [rad] of the pipe at a control step."""
        assert self._line is not None  # noqa: S101 - `begin` comes first
        self._navigation.update(now)
        north, east = self._navigation.position
        roll, pitch, yaw = observation[STARTS["attitude"] : STARTS["attitude"] + 3].tolist()
        altitude = observation.item(STARTS["altitude"])
        self._taken.append(_Taken(now.t, (north, east), yaw, (roll, pitch), altitude))
        if (step - self._late) % self._every == 0 and step >= self._late and self._seen.ok:
            self._look(self._line, self._taken[0])
        return self._line.beside((north, east), yaw)

    def _look(self, line: PipeLine, then: _Taken) -> None:
        """Take an image that has arrived: the middles of both ends of the piece, on the seabed."""
        x0, y0, x1, y1, x2, y2, x3, y3 = self._seen.corners.tolist()
        u, v = self._centre
        ahead, side = self._lens.on_seabed(
            (0.5 * (x0 + x1) - u, 0.5 * (y0 + y1) - v), then.tilt, then.altitude
        )
        behind, other = self._lens.on_seabed(
            (0.5 * (x2 + x3) - u, 0.5 * (y2 + y3) - v), then.tilt, then.altitude
        )
        north, east = _turned((0.5 * (ahead + behind), 0.5 * (side + other)), then.yaw)
        point = (then.position[0] + north, then.position[1] + east)
        line.look(then.t, point, then.yaw + atan2(side - other, ahead - behind))


def _turned(vector: Level, yaw: float) -> Level:
    """Return a vector forward and to starboard as north and east."""
    sine, cosine = sincos(yaw)
    forward, starboard = vector
    return cosine * forward - sine * starboard, sine * forward + cosine * starboard
