"""What all sensors have in common: their state, their sampling times and their noise.

Each sensor samples at multiples of its period, counted in physics steps, holds the value in between
and draws from a random stream of its own. How often it draws does not depend on its settings, so
switching noise off, or one more drop-out, leaves all later draws unchanged.

The state is a NumPy record and the noise of all readings is drawn in advance, so that
`sim/engine/perception.py` can sample all sensors in one compiled call per control step.
"""

from typing import Any

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array

DEFAULT_READINGS = 4096  # for which noise is drawn by default
Sounding = tuple[float, int]  # altitude [m] of the body's origin over the bottom, echoes of beams
Vector3 = tuple[float, float, float]
Record = Any  # a record of SENSOR; Numba reads its fields as attributes

SENSOR = np.dtype(
    [
        ("period", "i8"),  # [physics steps]
        ("slot", "i8"),  # index of the period of the last reading; -1 before the first
        ("readings", "i8"),  # so far, including failed ones
        ("measured_at", "i8"),  # [physics steps] when the values were measured
        ("values", "f8", 6),  # of the last valid reading
        ("sigma", "f8"),  # standard deviation, in the unit of the values
        ("rate_sigma", "f8"),  # [rad/s] of an AHRS
        ("bias", "f8", 6),  # in the unit of the values
        ("scale", "f8"),  # of a DVL: scale factor,
        ("dropout", "f8"),  # probability that a reading is missing,
        ("least_altitude", "f8"),  # [m] lowest altitude with bottom lock
        ("valid", "?"),  # whether the last reading succeeded
    ]
)


@njit(cache=True, error_model="numpy")
def due(sensor: Record, noise: Array, step: int) -> bool:
    """Return whether a reading is due at a physics step; if so, count it."""
    slot = step // sensor.period
    if slot == sensor.slot:
        return False
    if sensor.readings == noise.shape[0]:
        raise IndexError("the sensor has no noise left: it was set up for fewer readings")
    sensor.slot = slot
    sensor.readings += 1
    return True


class Sensor:
    """One sensor: its record, (1,) `SENSOR`, and its noise, (readings, k)."""

    def __init__(self, noise: Array, *, period_steps: int, **settings: float | Array) -> None:
        if period_steps < 1:
            raise ValueError(f"a sensor's period must be at least one step, not {period_steps}")
        self.noise = noise
        self.record = np.zeros(1, SENSOR)
        self.record["period"], self.record["slot"] = period_steps, -1
        for name, value in settings.items():
            self.record[name] = value
