"""Attitude and heading reference system (AHRS)."""

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import PI
from seamark.sim.physics import constants
from seamark.sim.sensors.sensor import DEFAULT_READINGS, Record, Sensor, Vector3, due


class Ahrs(Sensor):
    """Attitude and rates, (6,): roll, pitch, yaw in (-pi, pi] [rad], p, q, r [rad/s]."""

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        readings: int = DEFAULT_READINGS,
        period_steps: int = 5,
        sigma: float = 1e-4,
        bias: Vector3 = (0.0, 0.0, 0.0),
        rate_sigma: float = constants.AHRS_RATE_SIGMA.scalar,
    ) -> None:
        """Set up an AHRS.

        sigma [rad] and 20 Hz S: COLA2 sim_auv_nav_sensors.yaml; rate_sigma [rad/s] S: Stonefish.
        bias (3,) [rad] is added to roll, pitch and yaw.
        """
        noise = rng.standard_normal((readings, 6))
        super().__init__(
            noise,
            period_steps=period_steps,
            sigma=sigma,
            rate_sigma=rate_sigma,
            bias=np.array([*bias, 0.0, 0.0, 0.0]),
        )


@njit(cache=True, error_model="numpy")
def wrap_angle(angle: float) -> float:
    """Return an angle wrapped to (-pi, pi] [rad]; it may be outside by up to one turn."""
    if angle > PI:
        return angle - 2.0 * PI
    return angle + 2.0 * PI if angle <= -PI else angle


@njit(cache=True, error_model="numpy")
def sample_attitude(sensor: Record, noise: Array, step: int, pose: Array, velocity: Array) -> None:
    """Measure attitude and rates if a reading is due; `noise` is (k, 6), normal."""
    if not due(sensor, noise, step):
        return
    drawn, values, bias = noise[sensor.readings - 1], sensor.values, sensor.bias
    sensor.valid, sensor.measured_at = True, step
    values[0] = wrap_angle(pose[3] + sensor.sigma * drawn[0] + bias[0])
    values[1] = pose[4] + sensor.sigma * drawn[1] + bias[1]
    values[2] = wrap_angle(pose[5] + sensor.sigma * drawn[2] + bias[2])
    for i in range(3, 6):
        values[i] = velocity[i] + sensor.rate_sigma * drawn[i]
