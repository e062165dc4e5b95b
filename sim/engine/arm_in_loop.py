"""The arm in the loop: what is recorded and observed of it, and what its motors are told."""

import math
from collections.abc import Sequence

import numpy as np

from seamark.sim.engine.world import Arm
from seamark.sim.multibody.workpiece import MEASURED, MOTION
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import ARM_INDEX, SEARCH_INDEX, WORK_INDEX

_WORK = slice(WORK_INDEX["workpiece_x"], WORK_INDEX["tool_yaw"] + 1)
_WORK_FORCES = slice(WORK_INDEX["work_arm_n"], WORK_INDEX["work_rest_n"] + 1)
_DECOY = slice(SEARCH_INDEX["decoy_x"], SEARCH_INDEX["decoy_arm_n"])
_DECOY_FORCES = slice(SEARCH_INDEX["decoy_arm_n"], SEARCH_INDEX["decoy_rest_n"] + 1)
_PUSH = WORK_INDEX["work_push_n"]
_PUSH_AXES = slice(WORK_INDEX["work_fx"], WORK_INDEX["work_fz"] + 1)


def _columns(name: str, count: int) -> slice:
    first = ARM_INDEX[name]
    return slice(first, first + count)


class ArmInLoop:
    """The arm of one level."""

    def __init__(self, arm: Arm, seen: Array, corners: Array) -> None:
        """Take the arm of a level.

        `seen` is the part of the observation that is the arm's; `corners`, (8,) [px], are those
        that programs see at a control step.
        """
        self._plant, self._sensors = arm.plant, arm.sensors
        motors, feelers = arm.size
        self._true = np.zeros(3 * motors + 6)
        self._corners = corners
        self._seen_corners, self._seen = np.split(seen, [len(corners)])
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

    def motion(self) -> tuple[Array, Array, Array, Array]:
        """Return what images depend on: see `Posture.place`, without the vehicle.

        Coordinates of the motors' joints, (a,) [rad or m], their speeds, and where the workpiece
        and other things are, which is measured now.
        """
        self._plant.measure_work()
        work = self._plant.work
        return self._plant.joints(), self._plant.joint_rates(), work[:MOTION], work[MEASURED:]

    def measure(self, reading: int, row: Array) -> None:
        """Read the sensors at a control step; fill the row and the observation."""
        plant, (joints, speeds, efforts, wrench) = self._plant, self._parts
        joints[:], speeds[:] = plant.joints(), plant.joint_rates()
        efforts[:], wrench[:] = plant.readings.effort, plant.readings.wrench
        for columns, part in zip(self._columns, self._parts, strict=True):
            row[columns] = part
        row[self._touch], row[self._peak] = plant.readings.touch_n, plant.readings.peak_n[0]
        if len(plant.work):
            row[_WORK] = plant.work[:MEASURED]
            row[_WORK_FORCES] = plant.readings.work_n
            x, y, z = plant.readings.push.tolist()
            row[_PUSH] = math.sqrt(x * x + y * y + z * z)
            row[_PUSH_AXES] = plant.readings.push
        if len(plant.work) > MEASURED:
            row[_DECOY], row[_DECOY_FORCES] = plant.work[MEASURED:], plant.readings.other_n
        self._seen_corners[:] = self._corners
        self._sensors.read(reading, self._true, plant.readings.touch_n, self._seen)

    def command(self, sent: Sequence[float], arrived: Sequence[float], row: Array) -> None:
        """Record the speeds that a program sends; the motors tend to those that have arrived.

        With none, the joints rest.
        """
        row[self._reference] = sent or 0.0
        self._plant.drive(arrived)
