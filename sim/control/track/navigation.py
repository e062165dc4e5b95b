"""Where the vehicle is, by dead reckoning and acoustic fixes: a Kalman filter."""

from collections import deque
from typing import NamedTuple, TypeVar

from seamark.sim.control.observation import Observation
from seamark.sim.numerics.arrays import Array

AXES = (0, 1)  # north, east
DRIFT_M_S = 0.01  # E: of dead reckoning, from the bias of the DVL and of the compass
DRIFT_NOISE = 2e-3  # [m/s per root second] E: it turns with the heading
START_SHARE = 0.5  # standard deviation of each axis of a disc, as a share of its radius
LONGEST_DELAY_S = 30.0  # of fixes that are still used
Number = TypeVar("Number", float, Array)


class Measured(NamedTuple):
    """What navigation takes of an observation."""

    t: float  # [s]
    dt: float
    speeds: tuple[float, float]  # [m/s] surge, sway by the DVL
    depth: float  # [m]
    yaw: tuple[float, float]  # sine and cosine
    fix: tuple[float, float]  # [m] north, east
    fix_age: float  # [s]; negative before the first fix
    fix_sigma: float  # [m]
    pipe: tuple[float, float]  # offset [m] and angle [rad], as of the observation


def measured(observation: Observation, sine: float, cosine: float) -> Measured:
    """Return what navigation takes of an observation, given sine and cosine of its yaw."""
    velocity, fix = observation.velocity, observation.fix
    return Measured(
        t=observation.t,
        dt=observation.dt,
        speeds=(velocity.item(0), velocity.item(1)),
        depth=observation.depth,
        yaw=(sine, cosine),
        fix=(fix.item(0), fix.item(1)),
        fix_age=observation.fix_age,
        fix_sigma=observation.fix_sigma,
        pipe=(observation.pipe_offset, observation.pipe_angle),
    )


def to_body(north: Number, east: Number, yaw: tuple[float, float]) -> tuple[Number, Number]:
    """Return the parts of a vector forward and to starboard, given sine and cosine of the yaw."""
    sine, cosine = yaw
    return cosine * north + sine * east, cosine * east - sine * north


class Navigation:
    """Position north and east of the start [m], and the error of dead reckoning [m/s].

    p' = v + b with v from DVL and compass, b a random walk; a fix measures p as it was when the
    beacon answered (Kalman 1960; Fossen 2021, ch. 13). The innovation is that of the past, the gain
    that of the present, which is nearly the same: the delay is short against how fast the
    covariance changes. Both axes have one covariance.
    """

    def __init__(self, start_error_m: float, *, fixes: bool = True) -> None:
        """Set up for a start that may be so far off; without `fixes` it is dead reckoning alone."""
        self._fixes = fixes
        self.position, self._drift = [0.0, 0.0], [0.0, 0.0]
        start_sigma = max(START_SHARE * start_error_m, 0.01)
        self._variance = [start_sigma**2, 0.0, DRIFT_M_S**2]  # of p, of p and b, of b
        self._past: deque[list[float]] = deque()  # positions, the newest last
        self._pinged_at = -1.0  # [s] when the last fix that was used was measured

    def update(self, now: Measured) -> None:
        """Take the measurements of a step."""
        dt, (surge, sway), (sine, cosine) = now.dt, now.speeds, now.yaw
        speeds = (cosine * surge - sine * sway, sine * surge + cosine * sway)
        for axis in AXES:
            self.position[axis] += (speeds[axis] + self._drift[axis]) * dt
        own, both, drift = self._variance
        self._variance = [
            own + dt * (2.0 * both + dt * drift),
            both + dt * drift,
            drift + dt * DRIFT_NOISE**2,
        ]
        self._past.append([*self.position])
        if len(self._past) * dt > LONGEST_DELAY_S:
            self._past.popleft()
        if self._fixes and now.fix_age >= 0.0:
            self._take_fix(now)

    def _take_fix(self, now: Measured) -> None:
        measured_at, ago = now.t - now.fix_age, round(now.fix_age / now.dt)
        if measured_at <= self._pinged_at + 0.5 * now.dt or ago >= len(self._past):
            return
        self._pinged_at = measured_at
        own, both, drift = self._variance
        total = own + now.fix_sigma**2
        then = self._past[-1 - ago]
        for axis in AXES:
            innovation = now.fix[axis] - then[axis]
            self.position[axis] += own / total * innovation
            self._drift[axis] += both / total * innovation
            for past in self._past:
                if past is not then:
                    past[axis] += own / total * innovation
            then[axis] += own / total * innovation
        self._variance = [
            own - own / total * own,
            both - own / total * both,
            drift - both / total * both,
        ]
