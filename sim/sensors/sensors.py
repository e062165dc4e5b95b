"""Sensors: what the vehicle knows of its own motion.

Each sensor measures on its own grid of integer physics ticks, holds the value in between, and draws
from its own stream. How often it draws does not depend on its settings, so that noise switched off,
or a drop-out more, leaves all later draws where they are.

What a sensor is and what it holds stands in a record, and the noise of its readings is drawn
beforehand: `sim/engine/perception.py` measures all of them in one compiled call a control tick.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numba import njit

from seamark.sim.numerics.libm import PI
from seamark.sim.physics import constants
from seamark.sim.vehicles import Array

BEAMS = 4
LEAST_BEAMS = round(constants.DVL_LEAST_BEAMS.scalar)
DVL_RANGE_M = constants.DVL_RANGE_M.value
DVL_MOST_TILT_RAD = constants.DVL_MOST_TILT_RAD.scalar
READINGS = 4096  # for which noise is drawn if nothing is said
_NEAREST_M, _FARTHEST_M = DVL_RANGE_M

Reading = tuple[float, ...]
Sounding = tuple[float, int]  # altitude [m] of the body's origin over the bottom, echoes of beams
Record = Any  # one of SENSOR; Numba reads its fields as attributes

SENSOR = np.dtype(
    [
        ("period", "i8"),  # [ticks]
        ("slot", "i8"),  # of the grid, in which the last measurement was; -1 before the first
        ("readings", "i8"),  # made so far, also those that failed
        ("measured_at", "i8"),  # [ticks] when the values were measured
        ("values", "f8", 6),  # of the last good measurement
        ("sigma", "f8"),  # standard deviation, in the values' unit
        ("rate_sigma", "f8"),  # [rad/s] of an AHRS
        ("scale", "f8"),  # of a DVL: what it multiplies with,
        ("bias", "f8"),  # [m/s] what it adds to each axis,
        ("dropout", "f8"),  # the probability that a measurement is missing,
        ("least_altitude", "f8"),  # [m] and nearer than that it has no bottom lock
        ("valid", "?"),  # whether the last measurement succeeded
    ]
)


@dataclass(frozen=True, slots=True)
class Truth:
    """What is really so at one tick."""

    pose: Sequence[float]  # (6,) x y z roll pitch yaw [m, rad], NED
    velocity: Sequence[float]  # (6,) over ground, body frame [m/s, rad/s]
    altitude: float  # [m] of the body's origin above the bottom
    echoes: int = BEAMS  # of the DVL's beams


@njit(cache=True, error_model="numpy")
def wrapped(angle: float) -> float:
    """Return an angle within a turn of (-pi, pi] in that interval [rad]."""
    if angle > PI:
        return angle - 2.0 * PI
    return angle + 2.0 * PI if angle <= -PI else angle


@njit(cache=True, error_model="numpy")
def sees_bottom(pose: Array, sounding: Sounding, least_altitude: float) -> bool:
    """Return whether a DVL has bottom lock: within range, not tilted too far, enough echoes."""
    altitude, echoes = sounding
    level = abs(pose[3]) <= DVL_MOST_TILT_RAD and abs(pose[4]) <= DVL_MOST_TILT_RAD
    return least_altitude <= altitude <= _FARTHEST_M and level and echoes >= LEAST_BEAMS


@njit(cache=True, error_model="numpy")
def _due(sensor: Record, noise: Array, tick: int) -> bool:
    """Return whether `tick` has reached the next multiple of the period, and count the reading."""
    slot = tick // sensor.period
    if slot == sensor.slot:
        return False
    if sensor.readings == noise.shape[0]:
        raise IndexError("a sensor was made for fewer readings than it is asked for")
    sensor.slot = slot
    sensor.readings += 1
    return True


@njit(cache=True, error_model="numpy")
def measure_dvl(
    sensor: Record, noise: Array, tick: int, pose: Array, velocity: Array, sounding: Sounding
) -> None:
    """Measure velocity if it is time to; `noise` (k, 4) is normal but for its last column."""
    if not _due(sensor, noise, tick):
        return
    drawn = noise[sensor.readings - 1]
    locked = sees_bottom(pose, sounding, sensor.least_altitude)
    sensor.valid = locked and not drawn[3] < sensor.dropout
    if sensor.valid:
        sensor.measured_at = tick
        for i in range(3):
            true = velocity[i] * sensor.scale + sensor.bias
            sensor.values[i] = true + sensor.sigma * drawn[i]


@njit(cache=True, error_model="numpy")
def measure_depth(
    sensor: Record, noise: Array, tick: int, pose: Array, velocity: Array, sounding: Sounding
) -> None:
    """Measure depth if it is time to; `noise` (k, 1) is normal."""
    if _due(sensor, noise, tick):
        sensor.valid, sensor.measured_at = True, tick
        sensor.values[0] = pose[2] + sensor.sigma * noise[sensor.readings - 1, 0]


@njit(cache=True, error_model="numpy")
def measure_altitude(
    sensor: Record, noise: Array, tick: int, pose: Array, velocity: Array, sounding: Sounding
) -> None:
    """Measure the height above the bottom if it is time to; `noise` (k, 1) is normal."""
    if not _due(sensor, noise, tick):
        return
    sensor.valid = sees_bottom(pose, sounding, _NEAREST_M)
    if sensor.valid:
        sensor.measured_at = tick
        sensor.values[0] = sounding[0] + sensor.sigma * noise[sensor.readings - 1, 0]


@njit(cache=True, error_model="numpy")
def measure_attitude(
    sensor: Record, noise: Array, tick: int, pose: Array, velocity: Array, sounding: Sounding
) -> None:
    """Measure attitude and rates if it is time to; `noise` (k, 6) is normal."""
    if not _due(sensor, noise, tick):
        return
    drawn, values = noise[sensor.readings - 1], sensor.values
    sensor.valid, sensor.measured_at = True, tick
    values[0] = wrapped(pose[3] + sensor.sigma * drawn[0])
    values[1] = pose[4] + sensor.sigma * drawn[1]
    values[2] = wrapped(pose[5] + sensor.sigma * drawn[2])
    for i in range(3, 6):
        values[i] = velocity[i] + sensor.rate_sigma * drawn[i]


class Sensor:
    """One sensor: its record, (1,) `SENSOR`, and its noise, (readings, k)."""

    size: ClassVar[int]  # how many values it gives
    _measure: ClassVar[Callable[..., None]]

    def __init__(self, noise: Array, *, period_ticks: int, **settings: float) -> None:
        if period_ticks < 1:
            raise ValueError(f"a sensor's period must be at least one tick, not {period_ticks}")
        self.noise = noise
        self.record = np.zeros(1, SENSOR)
        self.record["period"], self.record["slot"] = period_ticks, -1
        for name, value in settings.items():
            self.record[name] = value

    def measure(self, tick: int, truth: Truth) -> tuple[Reading, bool]:
        """Return the latest values and whether the last measurement succeeded.

        A new measurement is made when `tick` has reached the next multiple of the period. After a
        failed one the last good values stay. Nothing is valid before the first good one.
        """
        pose, velocity = np.array(truth.pose, np.float64), np.array(truth.velocity, np.float64)
        sounding = (float(truth.altitude), int(truth.echoes))
        type(self)._measure(self.record[0], self.noise, tick, pose, velocity, sounding)
        values: list[float] = self.record["values"][0].tolist()
        return tuple(values[: self.size]), bool(self.record["valid"][0])

    def age(self, tick: int) -> int:
        """Return how many ticks ago the values were measured."""
        return tick - int(self.record["measured_at"][0])


class Dvl(Sensor):
    """Velocity over ground in the body frame, (3,) [m/s]; also tells whether it sees the bottom.

    The lever arm of its mounting is taken as compensated.
    """

    size = 3
    _measure = staticmethod(measure_dvl)

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        readings: int = READINGS,
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
        readings : int
            The most that it will make; so for all sensors.
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
        noise = [(*rng.standard_normal(3).tolist(), rng.random()) for _ in range(readings)]
        super().__init__(
            np.array(noise),
            period_ticks=period_ticks,
            sigma=sigma,
            bias=bias,
            scale=1.0 + scale_error,
            dropout=dropout,
            least_altitude=least_altitude_m,
        )


class Altimeter(Sensor):
    """Height above the bottom from the DVL's beams, (1,) [m]."""

    size = 1
    _measure = staticmethod(measure_altitude)

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        readings: int = READINGS,
        period_ticks: int = 20,
        sigma: float = constants.ALTIMETER_SIGMA_M.scalar,
    ) -> None:
        """Set up an altimeter; sigma [m]."""
        noise = rng.standard_normal((readings, 1))
        super().__init__(noise, period_ticks=period_ticks, sigma=sigma)


class DepthGauge(Sensor):
    """Depth of the body's origin, (1,) [m]."""

    size = 1
    _measure = staticmethod(measure_depth)

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        readings: int = READINGS,
        period_ticks: int = 20,
        sigma: float = 0.01,
    ) -> None:
        """Set up a depth gauge; sigma [m] and 5 Hz S: COLA2 sim_auv_nav_sensors.yaml."""
        noise = rng.standard_normal((readings, 1))
        super().__init__(noise, period_ticks=period_ticks, sigma=sigma)


class Ahrs(Sensor):
    """Attitude and rates, (6,): roll, pitch, yaw in (-pi, pi] [rad], p, q, r [rad/s]."""

    size = 6
    _measure = staticmethod(measure_attitude)

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        readings: int = READINGS,
        period_ticks: int = 5,
        sigma: float = 1e-4,
        rate_sigma: float = constants.AHRS_RATE_SIGMA.scalar,
    ) -> None:
        """Set up an AHRS.

        sigma [rad] and 20 Hz S: COLA2 sim_auv_nav_sensors.yaml; rate_sigma [rad/s] S: Stonefish.
        """
        noise = rng.standard_normal((readings, 6))
        super().__init__(noise, period_ticks=period_ticks, sigma=sigma, rate_sigma=rate_sigma)
