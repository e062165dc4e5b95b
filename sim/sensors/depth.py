"""Depth gauge."""

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.sensors.sensor import DEFAULT_READINGS, Record, Sensor, due


class DepthGauge(Sensor):
    """Depth of the body's origin, (1,) [m]."""

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        readings: int = DEFAULT_READINGS,
        period_steps: int = 20,
        sigma: float = 0.01,
    ) -> None:
        """Set up a depth gauge; sigma [m] and 5 Hz S: COLA2 sim_auv_nav_sensors.yaml."""
        noise = rng.standard_normal((readings, 1))
        super().__init__(noise, period_steps=period_steps, sigma=sigma)


@njit(cache=True, error_model="numpy")
def sample_depth(sensor: Record, noise: Array, step: int, pose: Array) -> None:
    """Measure the depth if a reading is due; `noise` is (k, 1), normal."""
    if due(sensor, noise, step):
        sensor.valid, sensor.measured_at = True, step
        sensor.values[0] = pose[2] + sensor.sigma * noise[sensor.readings - 1, 0]
