"""Altimeter: height above the bottom, from the beams of the DVL."""

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.physics import constants
from seamark.sim.sensors.dvl import RANGE_M, has_bottom_lock
from seamark.sim.sensors.sensor import DEFAULT_READINGS, Record, Sensor, Sounding, due

_LEAST_M = RANGE_M[0]


class Altimeter(Sensor):
    """Height of the body's origin above the bottom, (1,) [m]."""

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        readings: int = DEFAULT_READINGS,
        period_steps: int = 20,
        sigma: float = constants.ALTIMETER_SIGMA_M.scalar,
    ) -> None:
        """Set up an altimeter; sigma [m]."""
        noise = rng.standard_normal((readings, 1))
        super().__init__(noise, period_steps=period_steps, sigma=sigma)


@njit(cache=True, error_model="numpy")
def sample_altitude(
    sensor: Record, noise: Array, step: int, pose: Array, sounding: Sounding
) -> None:
    """Measure the altitude if a reading is due; `noise` is (k, 1), normal."""
    if not due(sensor, noise, step):
        return
    sensor.valid = has_bottom_lock(pose, sounding, _LEAST_M)
    if sensor.valid:
        sensor.measured_at = step
        sensor.values[0] = sounding[0] + sensor.sigma * noise[sensor.readings - 1, 0]
