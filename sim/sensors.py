"""Sensors: what the vehicle knows of its own motion.

Each sensor measures on its own grid of integer physics ticks, holds the value in between, and draws
from its own stream. How often it draws does not depend on its settings, so that noise switched off,
or a drop-out more, leaves all later draws where they are.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from sim import constants
from sim.elementary import PI

BEAMS = 4
LEAST_BEAMS = round(constants.DVL_LEAST_BEAMS.scalar)
DVL_RANGE_M = constants.DVL_RANGE_M.value
DVL_MOST_TILT_RAD = constants.DVL_MOST_TILT_RAD.scalar
NOISE_BLOCK = 256  # readings whose noise is drawn at once; the stream gives the same numbers

Reading = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Truth:
    """What is really so at one tick."""

    pose: Sequence[float]  # (6,) x y z roll pitch yaw [m, rad], NED
    velocity: Sequence[float]  # (6,) over ground, body frame [m/s, rad/s]
    altitude: float  # [m] of the body's origin above the bottom
    echoes: int = BEAMS  # of the DVL's beams


class Sensor(ABC):
    """The part that all sensors share: the grid of ticks, the held value and its age."""

    def __init__(self, size: int, *, rng: np.random.Generator, period_ticks: int) -> None:
        if period_ticks < 1:
            raise ValueError(f"a sensor's period must be at least one tick, not {period_ticks}")
        self._rng = rng
        self._period = period_ticks
        self._slot = -1
        self._measured_at = 0
        self._values: Reading = (0.0,) * size
        self._valid = False

    def measure(self, tick: int, truth: Truth) -> tuple[Reading, bool]:
        """Return the latest values and whether the last measurement succeeded.

        A new measurement is made when `tick` has reached the next multiple of the period. After a
        failed one the last good values stay. Nothing is valid before the first good one.
        """
        slot = tick // self._period
        if slot != self._slot:
            self._slot = slot
            reading, self._valid = self._read(truth)
            if self._valid:
                self._values = reading
                self._measured_at = tick
        return self._values, self._valid

    def age(self, tick: int) -> int:
        """Return how many ticks ago the values were measured."""
        return tick - self._measured_at

    @abstractmethod
    def _read(self, truth: Truth) -> tuple[Reading, bool]:
        """Return a new measurement and whether it succeeded."""


class Dvl(Sensor):
    """Velocity over ground in the body frame, (3,) [m/s]; also tells whether it sees the bottom.

    The lever arm of its mounting is taken as compensated.
    """

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        period_ticks: int = 20,
        sigma: float = 0.0015,
        bias: float = 0.0,
        scale_error: float = 0.0,
        dropout: float = 0.0,
        least_altitude_m: float = DVL_RANGE_M[0],
    ) -> None:
        """Set up a DVL.

        Parameters
        ----------
        period_ticks : int
            20 is 5 Hz at 100 steps a second. S: UWSim, COLA2.
        sigma : float [m/s]
            Standard deviation per axis. S: UWSim, COLA2, Stonefish.
        bias : float [m/s]
            Added to each axis.
        scale_error : float
            Relative error of all axes.
        dropout : float
            Probability that a measurement is missing.
        least_altitude_m : float [m]
            Nearer to the bottom it has no bottom lock.
        """
        super().__init__(3, rng=rng, period_ticks=period_ticks)
        self._sigma, self._bias = sigma, bias
        self._scale = 1.0 + scale_error
        self._dropout = dropout
        self._least_altitude = least_altitude_m

    def _read(self, truth: Truth) -> tuple[Reading, bool]:
        noise = self._rng.standard_normal(3).tolist()
        lost = self._rng.random() < self._dropout
        surge, sway, heave = (
            truth.velocity[i] * self._scale + self._bias + self._sigma * noise[i] for i in range(3)
        )
        locked = sees_bottom(truth, least_altitude_m=self._least_altitude)
        return (surge, sway, heave), locked and not lost


def sees_bottom(truth: Truth, *, least_altitude_m: float = DVL_RANGE_M[0]) -> bool:
    """Return whether a DVL has bottom lock: within range, not tilted too far, enough echoes."""
    high = DVL_RANGE_M[1]
    tilt = max(abs(truth.pose[3]), abs(truth.pose[4]))
    level = tilt <= DVL_MOST_TILT_RAD and truth.echoes >= LEAST_BEAMS
    return bool(least_altitude_m <= truth.altitude <= high and level)


def _noise(rng: np.random.Generator, size: int) -> Iterator[list[float]]:
    """Yield standard normal numbers, `size` at a time."""
    while True:
        yield from rng.standard_normal((NOISE_BLOCK, size)).tolist()


class Altimeter(Sensor):
    """Height above the bottom from the DVL's beams, (1,) [m]."""

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        period_ticks: int = 20,
        sigma: float = constants.ALTIMETER_SIGMA_M.scalar,
    ) -> None:
        """Set up an altimeter; sigma [m]."""
        super().__init__(1, rng=rng, period_ticks=period_ticks)
        self._sigma = sigma
        self._noise = _noise(rng, 1)

    def _read(self, truth: Truth) -> tuple[Reading, bool]:
        return (truth.altitude + self._sigma * next(self._noise)[0],), sees_bottom(truth)


class DepthGauge(Sensor):
    """Depth of the body's origin, (1,) [m]."""

    def __init__(
        self, rng: np.random.Generator, *, period_ticks: int = 20, sigma: float = 0.01
    ) -> None:
        """Set up a depth gauge; sigma [m] and 5 Hz S: COLA2 sim_auv_nav_sensors.yaml."""
        super().__init__(1, rng=rng, period_ticks=period_ticks)
        self._sigma = sigma
        self._noise = _noise(rng, 1)

    def _read(self, truth: Truth) -> tuple[Reading, bool]:
        return (truth.pose[2] + self._sigma * next(self._noise)[0],), True


class Ahrs(Sensor):
    """Attitude and rates, (6,): roll, pitch, yaw in (-pi, pi] [rad], p, q, r [rad/s]."""

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        period_ticks: int = 5,
        sigma: float = 1e-4,
        rate_sigma: float = constants.AHRS_RATE_SIGMA.scalar,
    ) -> None:
        """Set up an AHRS.

        sigma [rad] and 20 Hz S: COLA2 sim_auv_nav_sensors.yaml; rate_sigma [rad/s] S: Stonefish.
        """
        super().__init__(6, rng=rng, period_ticks=period_ticks)
        self._sigma, self._rate_sigma = sigma, rate_sigma
        self._noise = _noise(rng, 6)

    def _read(self, truth: Truth) -> tuple[Reading, bool]:
        _x, _y, _z, roll, pitch, yaw = truth.pose
        _u, _v, _w, p, q, r = truth.velocity
        n0, n1, n2, n3, n4, n5 = next(self._noise)
        angle, rate = self._sigma, self._rate_sigma
        reading = (
            *(wrapped(roll + angle * n0), pitch + angle * n1, wrapped(yaw + angle * n2)),
            *(p + rate * n3, q + rate * n4, r + rate * n5),
        )
        return reading, True


def wrapped(angle: float) -> float:
    """Return an angle within a turn of (-pi, pi] in that interval [rad]."""
    if angle > PI:
        return angle - 2.0 * PI
    return angle + 2.0 * PI if angle <= -PI else angle
