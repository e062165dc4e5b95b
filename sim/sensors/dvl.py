"""Doppler velocity log (DVL): velocity over ground, and whether it has bottom lock."""

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.physics import constants
from seamark.sim.sensors.sensor import DEFAULT_READINGS, Record, Sensor, Sounding, Vector3, due

RANGE_M = constants.DVL_RANGE_M.value  # least, greatest altitude
_GREATEST_M = RANGE_M[1]
_LEAST_BEAMS = round(constants.DVL_LEAST_BEAMS.scalar)
_MOST_TILT_RAD = constants.DVL_MOST_TILT_RAD.scalar


class Dvl(Sensor):
    """Velocity over ground in the body frame, (3,) [m/s].

    The lever arm of its mounting is assumed to be compensated.
    """

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        readings: int = DEFAULT_READINGS,
        period_steps: int = 20,
        sigma: float = 0.0015,
        bias: Vector3 = (0.0, 0.0, 0.0),
        scale_error: float = 0.0,
        dropout: float = 0.0,
        least_altitude_m: float = RANGE_M[0],
    ) -> None:
        """Set up a DVL.

        Parameters
        ----------
        readings : int
            Greatest number of readings.
        period_steps : int
            20 is 5 Hz at 100 steps a second. S: UWSim, COLA2.
        sigma : float [m/s]
            Standard deviation per axis. S: UWSim, COLA2, Stonefish.
        bias : (3,) [m/s]
            Added to the axes.
        scale_error : float
            Relative error of all axes.
        dropout : float
            Probability that a reading is missing.
        least_altitude_m : float [m]
            Below it there is no bottom lock.
        """
        noise = [(*rng.standard_normal(3).tolist(), rng.random()) for _ in range(readings)]
        super().__init__(
            np.array(noise),
            period_steps=period_steps,
            sigma=sigma,
            bias=np.array([*bias, 0.0, 0.0, 0.0]),
            scale=1.0 + scale_error,
            dropout=dropout,
            least_altitude=least_altitude_m,
        )


@njit(cache=True, error_model="numpy")
def has_bottom_lock(pose: Array, sounding: Sounding, least_altitude: float) -> bool:
    """Return whether the bottom is in range, the tilt small and the echoes enough."""
    altitude, echoes = sounding
    level = abs(pose[3]) <= _MOST_TILT_RAD and abs(pose[4]) <= _MOST_TILT_RAD
    return least_altitude <= altitude <= _GREATEST_M and level and echoes >= _LEAST_BEAMS


@njit(cache=True, error_model="numpy")
def sample_dvl(
    sensor: Record, noise: Array, step: int, pose: Array, velocity: Array, sounding: Sounding
) -> None:
    """Measure the velocity if a reading is due.

    `noise` is (k, 4): normal numbers for the three axes, and one in [0, 1) for the drop-out.
    """
    if not due(sensor, noise, step):
        return
    drawn = noise[sensor.readings - 1]
    locked = has_bottom_lock(pose, sounding, sensor.least_altitude)
    sensor.valid = locked and not drawn[3] < sensor.dropout
    if sensor.valid:
        sensor.measured_at = step
        for i in range(3):
            true = velocity[i] * sensor.scale + sensor.bias[i]
            sensor.values[i] = true + sensor.sigma * drawn[i]
