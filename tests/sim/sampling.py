"""Reads a sensor by the compiled functions that perception calls."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seamark.sim.sensors.ahrs import Ahrs, sample_attitude
from seamark.sim.sensors.altimeter import Altimeter, sample_altitude
from seamark.sim.sensors.depth import DepthGauge, sample_depth
from seamark.sim.sensors.dvl import Dvl, sample_dvl
from seamark.sim.sensors.sensor import Sensor


@dataclass(frozen=True, slots=True)
class Truth:
    """The true motion at one physics step."""

    pose: Sequence[float]  # (6,) x y z roll pitch yaw [m, rad], NED
    velocity: Sequence[float]  # (6,) over ground, body frame [m/s, rad/s]
    altitude: float  # [m] of the body's origin above the bottom
    echoes: int = 4  # of the DVL's beams


def sample(sensor: Sensor, step: int, truth: Truth) -> tuple[tuple[float, ...], bool]:
    """Return the values that a sensor holds after a physics step, and whether they are valid."""
    pose, velocity = np.array(truth.pose, np.float64), np.array(truth.velocity, np.float64)
    sounding = (float(truth.altitude), int(truth.echoes))
    record = sensor.record[0]
    match sensor:
        case Dvl():
            size = 3
            sample_dvl(record, sensor.noise, step, pose, velocity, sounding)
        case Ahrs():
            size = 6
            sample_attitude(record, sensor.noise, step, pose, velocity)
        case DepthGauge():
            size = 1
            sample_depth(record, sensor.noise, step, pose)
        case Altimeter():
            size = 1
            sample_altitude(record, sensor.noise, step, pose, sounding)
        case _:
            raise TypeError(f"{type(sensor).__name__} is not a sensor of the vehicle")
    return tuple(record["values"][:size].tolist()), bool(record["valid"])
