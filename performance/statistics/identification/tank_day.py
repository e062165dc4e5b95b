"""A tank day: a simulated vehicle is driven about in still water, and its sensors are logged."""

from pathlib import Path

import numpy as np

from seamark.mission_logs.samples import Samples
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.current import Current
from seamark.sim.physics.dynamics import body_parameters
from seamark.sim.physics.plant import STEP_S, Plant
from seamark.sim.physics.thrusters import commands_for, pack_curve
from seamark.sim.sensors.ahrs import Ahrs, sample_attitude
from seamark.sim.sensors.dvl import Dvl, sample_dvl
from seamark.sim.vehicles import Vehicle

STEPS = 5  # physics steps of a row: 20 Hz
DEPTH_M, ALTITUDE_M = 20.0, 20.0  # a tank so deep that nothing touches
BEAMS = 4
HOLD_S = (1.5, 5.0)  # shortest and longest time of one push
PUSH = (0.2, 0.9)  # least and greatest share of the strongest thruster's limit
ALONE = 0.7  # share of pushes along one axis
YAW_SHARE = 0.4  # of the strongest push in yaw: about two radians a second
STIFFER = 4.0  # than the righting moment: the hold of roll and pitch
TILT_RAD = 0.35
SECONDS = 240.0
_STREAM_OF_SENSORS = 1


class Driver:
    """Drives a vehicle by pushes along one axis or several at once.

    The last second of each is without thrust, so the vehicle also slows down. Roll and pitch are
    held as an autopilot does, about angles that change with each push: Munk's moment would turn a
    vehicle over that is only held by its weight.
    """

    def __init__(self, vehicle: Vehicle, generator: np.random.Generator) -> None:
        self._generator = generator
        self._curve = pack_curve(vehicle.curve)
        self._thrust_of = np.linalg.pinv(vehicle.allocation())
        largest = np.maximum(np.abs(self._thrust_of).max(axis=0), 1e-9)
        self._most = min(vehicle.curve.limits.value) / largest
        self._most[5] *= YAW_SHARE
        body = body_parameters(vehicle)
        self._stiff = STIFFER * abs(body.moment[2])
        inertia = np.diag(body.mass)[3:5]
        self._damp = np.sqrt(self._stiff * inertia)
        self._wrench, self._angles = np.zeros(6), np.zeros(2)
        self._until, self._rest = 0, 0

    def command(self, row: int, pose: Array, velocity: Array) -> Array:
        """Return the commands (n,) of a row, from the true pose and velocity, (6,) each."""
        if row >= self._until:
            self._push(row)
        wrench = np.zeros(6) if row >= self._rest else self._wrench.copy()
        tilt = pose[3:5] - self._angles
        wrench[3:5] = -self._stiff * tilt - self._damp * velocity[3:5]
        command = np.zeros(self._thrust_of.shape[0])
        commands_for(self._thrust_of @ wrench, self._curve, command)
        return command

    def _push(self, row: int) -> None:
        draw, second = self._generator, round(1.0 / (STEPS * STEP_S))
        if draw.random() < ALONE:
            self._wrench = np.zeros(6)
            axis = draw.choice([0, 1, 2, 5])
            self._wrench[axis] = draw.choice([-1.0, 1.0]) * draw.uniform(*PUSH) * self._most[axis]
        else:
            self._wrench = draw.uniform(-PUSH[1], PUSH[1], 6) * self._most / 3.0
        self._angles = draw.uniform(-TILT_RAD, TILT_RAD, 2)
        self._rest = row + round(draw.uniform(*HOLD_S) * second)
        self._until = self._rest + second


def log_of(vehicle: Vehicle, seed: int, *, seconds: float = SECONDS, noise: float = 1.0) -> Samples:
    """Return the log of a tank day: commands, velocity of the DVL at 5 Hz, rates and angles.

    Parameters
    ----------
    noise
        By which the noise of the DVL and of the AHRS is multiplied; 0: none.
    """
    rows = round(seconds / (STEPS * STEP_S)) + 1
    driver, driven = Driver(vehicle, np.random.default_rng(seed)), []
    sensors = np.random.default_rng([seed, _STREAM_OF_SENSORS])
    dvl, ahrs = Dvl(sensors, readings=rows), Ahrs(sensors, readings=rows)
    for sensor in (dvl, ahrs):
        sensor.record["sigma"] *= noise
        sensor.record["rate_sigma"] *= noise
    plant = Plant(vehicle, Current(0.0))
    plant.reset(np.array([0.0, 0.0, DEPTH_M, 0.0, 0.0, 0.0]))
    columns = {name: np.full(rows, np.nan) for name in "u v w p q r roll pitch yaw".split()}
    for row in range(rows):
        pose, velocity = plant.pose(), plant.velocity()
        sample_attitude(ahrs.record[0], ahrs.noise, row * STEPS, pose, velocity)
        read = dvl.record["readings"][0]
        sample_dvl(dvl.record[0], dvl.noise, row * STEPS, pose, velocity, (ALTITUDE_M, BEAMS))
        if dvl.record["readings"][0] > read and dvl.record["valid"][0]:
            for at, name in enumerate("uvw"):
                columns[name][row] = dvl.record["values"][0][at]
        for at, name in enumerate(("roll", "pitch", "yaw", "p", "q", "r")):
            columns[name][row] = ahrs.record["values"][0][at]
        driven.append(driver.command(row, pose, velocity))
        plant.advance(row * STEPS, driven[-1], STEPS)
    columns |= {f"command_{at}": one for at, one in enumerate(np.stack(driven, axis=1))}
    return Samples(
        label="the log",
        noun="row",
        stamps=np.arange(rows, dtype=np.float64) * np.float64(STEPS * STEP_S),
        numbers=np.arange(rows),
        values=columns,
    )


def write_csv(log: Samples, path: Path) -> None:
    """Write a log as a file that `seamark identify` reads."""
    names = ["t", *log.values]
    table = np.column_stack([log.stamps, *log.values.values()])
    lines = [",".join("" if np.isnan(one) else repr(float(one)) for one in row) for row in table]
    path.write_text("\n".join([",".join(names), *lines, ""]), encoding="utf-8")
