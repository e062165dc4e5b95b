"""The arm in the loop: what is recorded and observed of it, and what its motors are told."""

from collections.abc import Sequence

import numpy as np

from seamark.sim.engine.world import Arm
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import ARM_INDEX


def _columns(name: str, count: int) -> slice:
    first = ARM_INDEX[name]
    return slice(first, first + count)


class ArmInLoop:
    """The arm of one level."""

    def __init__(self, arm: Arm, seen: Array) -> None:
        """Take the arm of a level, and the part of the observation that is the arm's."""
        self._plant, self._sensors = arm.plant, arm.sensors
        motors, feelers = arm.size
        self._true = np.zeros(3 * motors + 6)
        self._seen = seen
        self._columns = [
            _columns("joint_0", motors),
            _columns("joint_speed_0", motors),
            _columns("joint_effort_0", motors),
            _columns("wrist_fx", 6),
        ]
        ends = np.cumsum([motors, motors, motors])
        self._parts = np.split(self._true, ends)
        self._reference = _columns("joint_ref_0", motors)
        self._touch = _columns("touch_0", feelers)
        self._peak = ARM_INDEX["arm_peak_n"]

    def joints(self) -> tuple[Array, Array]:
        """Return the coordinates of the motors' joints, (a,) [rad or m], and their speeds."""
        return self._plant.joints(), self._plant.joint_rates()

    def measure(self, reading: int, row: Array) -> None:
        """Read the sensors at a control step; fill the row and the observation."""
        plant, (joints, speeds, efforts, wrench) = self._plant, self._parts
        joints[:], speeds[:] = self.joints()
        efforts[:], wrench[:] = plant.readings.effort, plant.readings.wrench
        for columns, part in zip(self._columns, self._parts, strict=True):
            row[columns] = part
        row[self._touch], row[self._peak] = plant.readings.touch_n, plant.readings.peak_n[0]
        self._sensors.read(reading, self._true, plant.readings.touch_n, self._seen)

    def command(self, sent: Sequence[float], arrived: Sequence[float], row: Array) -> None:
        """Record the speeds that a program sends; the motors tend to those that have arrived.

        With none, the joints rest.
        """
        row[self._reference] = sent or 0.0
        self._plant.drive(arrived)
